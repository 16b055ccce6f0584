// The only way to read the tiles of a result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/image.h"
#include "src/base/result.h"
#include "src/result/far_files.h"
#include "src/result/store/data_file.h"
#include "src/result/store/points_file.h"
#include "src/result/store/points_tile.h"
#include "src/result/store/tile_reader.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Results of periodic clouds have cells with vertices that are images, and points that are several vertices of a tile.
// Code that does not know of this refuses such results.
enum class Periods : std::uint8_t { refused, known };

// Reads the tiles of one version of a result, as its manifest lists them. Cheap to copy, and safe to use from several
// threads. While a copy exists, no writer removes the files of this version. A result may be far, in an object store or
// behind HTTP: then files are fetched when they are needed, and the folder is the name of a place there. Of a far
// result nothing is held: when it is replaced, reading it is an error.
class TileSource {
 public:
  // Opens the newest version, or the one that the path names (named_version()). Reads only the manifest. Errors: those
  // of read_manifest() and read_far_manifest(); usage, with the versions that can be read, when the named one cannot,
  // and for a periodic result that is refused.
  static Result<TileSource> open(const std::filesystem::path& out, Periods periods = Periods::refused);

  // Tiles of a result that is being made. REQUIRES: the files are in the folder as in a finished result.
  static TileSource draft(std::filesystem::path folder, Manifest manifest);

  // Returns the same version as if it had no computed columns.
  TileSource without_columns() const;

  // Returns a copy that can be stopped: after `stop` is requested, read() of a tile whose cells must be rebuilt soon
  // returns the error interrupted.
  TileSource stopped_by(std::stop_token stop) const;

  const std::filesystem::path& folder() const { return inside_->folder; }
  bool is_far() const { return inside_->far != nullptr; }
  const Manifest& manifest() const { return inside_->manifest; }
  // The period of the result.
  const Period& period() const { return inside_->period; }
  // The number of tiles that have points. They are numbered from 0, in the order of their ids.
  std::size_t tiles() const { return manifest().tiles.size(); }
  const TileEntry& entry(std::size_t i) const { return manifest().tiles[i]; }
  // The number of the tile; nothing for a tile without points.
  std::optional<std::size_t> find(TileId tile) const;
  // The path of a tile's file, for error messages and for code that needs the bytes.
  std::filesystem::path file(std::size_t i) const { return tile_file(folder(), entry(i)); }
  std::filesystem::path file(TileId tile) const;

  // The most memory in bytes that read() needs to return a tile with its cells.
  std::uint64_t work_bytes(std::size_t i) const;

  // Checks the tile's file against the checksum in the manifest. Errors: corrupt, io.
  Status check(std::size_t i) const;
  // Reads a tile, checks every array, and compares the tile with its entry in the manifest. The cells of a tile that is
  // kept as points are rebuilt (src/tiling/tile/rebuild.h). Errors: corrupt, with file and array; io; memory when a
  // kernel cannot number the tile's points.
  Result<StoredTile> read(std::size_t i, const TileFields& fields) const;
  // Reads the file of a tile that is kept as points, without rebuilding cells. REQUIRES: the tile is kept as points.
  // Errors: as read().
  Result<PointsTile> read_as_points(std::size_t i, const PointsFields& fields) const;
  // Reads only the source indices of the tile's own vertices, in the file's order. Errors: as read().
  Result<std::vector<PointId>> read_own_ids(std::size_t i) const;
  // Reads the duplicates. Errors: those of tessera::read_duplicates().
  Result<std::vector<DuplicatePair>> read_duplicates() const;
  // Checks a file of the result that is not one of its tiles. Errors: corrupt, io.
  Status check(const std::filesystem::path& file, const result::ToldFile& told) const;

 private:
  Result<DataFile> open_file(std::size_t i) const;
  Result<StoredTile> read_points(std::size_t i, const TileFields& fields) const;
  Result<PointsTile> read_points_with_columns(std::size_t i, const PointsFields& fields) const;
  // Whether a vertex can have an offset of this code.
  bool has_offset(std::uint32_t code) const;
  // The manifest with the columns that the files have.
  const Manifest& whole() const { return inside_->whole ? *inside_->whole : inside_->manifest; }
  struct Inside {
    std::filesystem::path folder;
    Manifest manifest;
    FileHandle held;                             // held_manifest.h
    std::shared_ptr<result::FarFiles> far = {};  // null: the result is in a folder
    std::shared_ptr<const Manifest> whole = {};  // null: all columns are in `manifest`
    Period period = {};
  };
  explicit TileSource(std::shared_ptr<const Inside> inside) : inside_(std::move(inside)) {}
  std::shared_ptr<const Inside> inside_;
  std::stop_token stop_;
};

}  // namespace tessera

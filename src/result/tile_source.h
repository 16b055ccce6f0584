// The one door to the tiles of a result: of one version, as its manifest has them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/store/points_file.h"
#include "src/result/store/points_tile.h"
#include "src/result/store/tile_reader.h"
#include "src/result/store/tile_store.h"

namespace tessera {

// Cheap to copy; for several threads at once. As long as a copy is there, no later version takes the files away.
class TileSource {
 public:
  // The newest version. Reads the manifest alone. Errors: those of read_manifest().
  static Result<TileSource> open(const std::filesystem::path& out);

  // The same; read() of a tile whose cells must be made ends with error interrupted soon after `stop` is requested.
  TileSource stopped_by(std::stop_token stop) const;

  const std::filesystem::path& folder() const { return inside_->folder; }
  const Manifest& manifest() const { return inside_->manifest; }
  // The tiles that have points are numbered from 0, by their ids.
  std::size_t tiles() const { return manifest().tiles.size(); }
  const TileEntry& entry(std::size_t i) const { return manifest().tiles[i]; }
  // Nothing for a tile without points.
  std::optional<std::size_t> find(TileId tile) const;
  // Where a tile stands, for errors and for whoever wants the bytes.
  std::filesystem::path file(std::size_t i) const { return tile_file(folder(), entry(i)); }
  std::filesystem::path file(TileId tile) const;

  // What read() takes of memory at most, in bytes, when it gives cells.
  std::uint64_t work_bytes(std::size_t i) const;

  // The tile's file has the checksum that the manifest says. Errors: corrupt, io.
  Status check(std::size_t i) const;
  // Every array is checked, and all is compared with what the manifest says of the tile. Cells of a tile that is kept
  // as points are made again (src/tiling/tile/rebuild.h). Errors: corrupt, which names file and place; io; memory when
  // a kernel cannot number the tile's points.
  Result<StoredTile> read(std::size_t i, const TileParts& parts) const;
  // What the file of a tile that is kept as points holds. Errors as above. REQUIRES: it is.
  Result<PointsTile> read_as_points(std::size_t i, const PointsParts& parts) const;
  // Only the source indices of the tile's own vertices, in the file's order. Errors as above.
  Result<std::vector<PointId>> read_own_ids(std::size_t i) const;

 private:
  Result<StoredTile> read_points(std::size_t i, const TileParts& parts) const;
  struct Inside {
    std::filesystem::path folder;
    Manifest manifest;
    FileHandle held;  // held_manifest.h
  };
  explicit TileSource(std::shared_ptr<const Inside> inside) : inside_(std::move(inside)) {}
  std::shared_ptr<const Inside> inside_;
  std::stop_token stop_;
};

}  // namespace tessera

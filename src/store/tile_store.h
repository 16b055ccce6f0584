// The result folder: VTKHDF tile files, master file and manifest. Format: FORMAT.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/tile/tile_mesh.h"

namespace tessera {

// What the manifest says of one tile file.
struct TileEntry {
  std::uint32_t tile = 0;
  std::uint64_t points = 0;  // vertices in the file, foreign ones included
  std::uint64_t own_points = 0;
  std::uint64_t cells = 0;  // cells in the file
  std::uint64_t main_cells = 0;
  std::uint64_t bytes = 0;
  std::uint64_t xxh3 = 0;  // XXH3-64 of the file's bytes
  friend bool operator==(const TileEntry&, const TileEntry&) = default;
};

struct StoreOptions {
  bool neighbors = true;
  std::vector<Attribute> schema;  // of `rows` below
};

// Writes OUT/tiles/NNNNNN.vtkhdf under a temporary name and checksums it; `rows`: mesh.points.size() rows of the
// schema. A thread of the store syncs and renames it while the caller goes on: the tile counts as stored, and shows in
// stored_tiles(), only after that. Its error is told by the next call for the same folder. Arrays are not kept: the
// mesh may go when this returns. Safe to call from several threads for different tiles.
Result<TileEntry> write_tile(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                             std::span<const std::byte> rows, const StoreOptions& options);
// Also leaves a side file (OUT/tiles/NNNNNN.done, the entry as JSON), by which a resumed run knows the tile is stored;
// finish_store() removes them. Waits for tiles on their way to disk; so do read_tile() and finish_store().
Result<std::vector<TileEntry>> stored_tiles(const std::filesystem::path& out);

// Reads a tile file back. Every array is checked (lengths, ranges, ghost flags); corrupt names the file and the place.
// owners is left empty: the file does not say.
struct StoredTile {
  TileMesh mesh;
  std::vector<Attribute> schema;
  std::vector<std::byte> rows;
};
Result<StoredTile> read_tile(const std::filesystem::path& out, TileId tile, bool with_rows = false);
// The same without cells.
Result<StoredTile> read_tile_vertices(const std::filesystem::path& out, TileId tile, bool with_rows = false);

struct Manifest {
  int format_version = 1;
  std::string software_version;
  std::vector<std::string> command;
  struct Input {
    std::string path;
    std::uint64_t bytes = 0;
    std::int64_t modified_ns = 0;
  };
  std::vector<Input> inputs;
  int dimension = 3;
  std::string crs;
  std::string partition_kind;
  std::vector<Box> boxes;
  Bounds bounds;
  bool neighbors = true;
  std::vector<Attribute> schema;
  std::vector<TileEntry> tiles;  // of non-empty tiles, by tile id
  std::uint64_t points_read = 0, invalid = 0, filtered = 0, duplicates = 0, vertices = 0, cells = 0;
  std::uint64_t duplicates_xxh3 = 0;      // of duplicates.bin; 0 when there is none
  std::uint64_t master_xxh3 = 0;          // of triangulation.vtkhdf
  std::map<std::string, double> seconds;  // by phase
  std::map<std::string, double> figures;  // messages, peak memory, ...: for people, not for programs
};

// Writes triangulation.vtkhdf (virtual datasets over the tiles), duplicates.bin when `duplicates` is not empty
// (ascending), and the manifest last. Sets the manifest's checksums, and the schema's names as they are stored.
Status finish_store(const std::filesystem::path& out, Manifest& manifest,
                    std::span<const std::pair<std::uint64_t, std::uint64_t>> duplicates);
// Error io when there is none, corrupt when it is damaged or from a future version.
Result<Manifest> read_manifest(const std::filesystem::path& out);
Result<std::vector<std::pair<std::uint64_t, std::uint64_t>>> read_duplicates(const std::filesystem::path& out);

std::filesystem::path tile_file(const std::filesystem::path& out, TileId tile);

}  // namespace tessera

// The result folder: tile files, master file and manifest. Format: FORMAT.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/big_vector.h"
#include "src/base/duplicate_policy.h"
#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/geometry/mesh/cell_stream.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/store/digest.h"
#include "src/result/store/external_sort.h"

namespace tessera {

struct HeightRange {
  double lo = 0, hi = 0;
  friend bool operator==(const HeightRange&, const HeightRange&) = default;
};

// What the manifest says of one tile file.
struct TileEntry {
  TileId tile;
  TileKind kind = TileKind::cells;  // of the file
  std::uint64_t points = 0;         // vertices in the file, foreign ones included
  std::uint64_t own_points = 0;
  std::uint64_t cells = 0;  // cells in the file, or that follow from it
  std::uint64_t main_cells = 0;
  std::uint64_t bytes = 0;
  std::uint32_t version = 1;     // of the result, that wrote the file
  std::uint64_t xxh3 = 0;        // checksum of the file: see data_sum_of()
  std::optional<Digest> digest;  // of main cells and own vertices; older software wrote none
  // 2D: of own vertices, from their attribute z, those that are finite. Older software wrote none.
  std::optional<HeightRange> heights = {};
  friend bool operator==(const TileEntry&, const TileEntry&) = default;
};

// The tile's file in a result folder.
inline std::filesystem::path tile_file(const std::filesystem::path& out, const TileEntry& entry) {
  return tile_file(out, entry.tile, entry.version, entry.kind);
}

// What the checksums of tile files and of duplicates.bin are made of, in a folder of this format.
constexpr SumOf data_sum_of(int format) { return format < 3 ? SumOf::bytes : SumOf::pieces; }

struct EarlyCells;      // early_cells.h
struct PointsTileView;  // points_tile.h

struct StoreOptions {
  bool neighbors = true;
  std::vector<Attribute> schema = {};    // of `rows` below
  std::filesystem::path lock_file = {};  // of OUT's lock: check_held()
  NodeId node = {};                      // that stores it
  bool sync = false;                     // the tile is on the disk before anybody hears that it is stored
  std::stop_token stop = {};             // write_tile() then soon throws Stopped, and leaves nothing
};

// Writes OUT/tiles/NNNNNN.vtu under a temporary name, checksums and digests it; `rows`: mesh.points.size() rows of the
// schema. Safe to call from several threads for different tiles. With `cells` theirs are written: of the mesh `cells`
// and `neighbors` are not looked at. `early`: cells of the mesh that are in the file already, and not among `cells`.
Result<TileEntry> write_tile(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                             std::span<const std::byte> rows, const StoreOptions& options);
Result<TileEntry> write_tile(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                             const CellStream& cells, std::span<const std::byte> rows, const StoreOptions& options,
                             const EarlyCells* early = nullptr);
// The same for OUT/tiles/NNNNNN.pts: the tile's own points in Hilbert order, and the foreign vertices of its cells,
// from which these follow. `counted`: of the cells, which nobody keeps.
struct CountedCells {
  std::uint64_t cells = 0, main_cells = 0;
  Digest digest;  // of the main ones
};
Result<TileEntry> write_points_tile(const std::filesystem::path& out, const PointsTileView& tile,
                                    const CountedCells& counted, const StoreOptions& options);
// Both also add a line to the node's OUT/tiles/node-NNNNNN.done, the entry and its XXH3-64, by which a resumed
// run knows that the tile is stored; finish_store() removes it. One file for all: to make a file takes longer than to
// fill it. Of the tiles that are `wanted`, all by default, each file is read once: one that is not what was stored, or
// whose line is damaged, is not listed, so that the tile is made again.
Result<std::vector<TileEntry>> stored_tiles(const std::filesystem::path& out,
                                            const std::function<bool(TileId)>& wanted = {});

// An entry on its way to another node. Nothing when these are no bytes of an entry, or some of them have changed.
BigVector<std::byte> bytes_of(const TileEntry& entry);
std::optional<TileEntry> tile_entry_of(std::span<const std::byte> bytes);

// A tile as it was stored; src/result reads it.
struct StoredTile {
  TileMesh mesh;
  std::vector<Attribute> schema;
  std::vector<std::byte> rows;
  std::vector<Attribute> cell_schema;
  std::vector<std::vector<std::byte>> cell_columns;  // in its order, by cell; if they were asked for
};

// What was computed of a result and added to it.
struct ResultColumn {
  std::string name;
  bool of_cells = false;  // else of vertices, and in the schema, too
  AttributeType type = AttributeType::f64;
  std::string unit;                  // of its values; "" when nobody knows
  std::uint32_t version = 2;         // of the result, that it came with
  std::vector<std::string> command;  // what made it,
  std::string software_version;      // and which tessera
  std::optional<double> total = {};  // over all cells or vertices, each once; if it says something
  friend bool operator==(const ResultColumn&, const ResultColumn&) = default;
};

struct Manifest {
  int format_version = unchanged_format;  // of the folder
  std::uint32_t version = 1;              // of the result: one more with each change (src/result/new_version.h)
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
  std::vector<Box> boxes;  // by tile id
  // As Partition::to_json() gives it, for Partition::from_json(): tile_of() of the result.
  std::string partition;
  Bounds bounds;
  // There when the tiles are not a whole triangulation, but those of its cells that meet a closed box.
  struct Region {
    Box box;
    bool complete = true;  // all of those, and no others; else the tiles tell which cells are final
  };
  std::optional<Region> region;
  bool neighbors = true;
  std::vector<Attribute> schema;
  std::vector<ResultColumn> columns;  // what was added to the result; those of vertices are the last of the schema
  std::vector<TileEntry> tiles;       // of non-empty tiles, by tile id
  std::uint64_t points_read = 0, invalid = 0, filtered = 0, duplicates = 0, vertices = 0, cells = 0;
  DuplicatePolicy keep = DuplicatePolicy::first;  // of equal points
  std::optional<std::uint64_t>
      other_heights;                  // 2D: duplicates not at the height of the kept point, if heights are known
  std::optional<Digest> digest;       // the sum of the tiles'; none when a tile has none
  std::uint64_t duplicates_xxh3 = 0;  // of duplicates.bin; 0 when there is none
  std::uint64_t master_xxh3 = 0;      // of the master file
  std::optional<std::uint64_t> previous_master_xxh3 = {};  // of the version before; it may stand until the next change
  std::map<std::string, double> seconds;                   // by phase
  std::map<std::string, double> figures;                   // messages, peak memory, ...: for people, not for programs
};

struct DuplicatePair {
  PointId duplicate, kept;
  friend auto operator<=>(const DuplicatePair&, const DuplicatePair&) = default;
};
// There may be more than fit into memory.
using DuplicateSort = ExternalSort<DuplicatePair>;

// Writes triangulation.pvtu (which names the tiles), duplicates.bin when `duplicates` is not empty
// and the manifest last. Sets the manifest's digest, checksums, number of duplicates, and the schema's names as they
// are stored; then `before_manifest` may add to the manifest, and to the folder what shall be there when it is.
Status finish_store(
    const std::filesystem::path& out, Manifest& manifest, DuplicateSort& duplicates,
    const std::function<Status()>& before_manifest = [] { return success(); });
// The same with pairs in memory.
Status finish_store(const std::filesystem::path& out, Manifest& manifest, std::span<const DuplicatePair> duplicates);
// Removes what the runs of a finished result may have left in it: the side files, files that were being written.
void remove_side_files(const std::filesystem::path& out);
// Error io when there is none, corrupt when it is damaged or from a future version.
Result<Manifest> read_manifest(const std::filesystem::path& out);
// The error when there is none.
Error no_manifest(const std::filesystem::path& out);
// Of its bytes; `path` is for errors.
Result<Manifest> parse_manifest(const std::filesystem::path& path, std::span<const std::byte> bytes);
// `keep`: as the manifest has it; pairs that it cannot make are corrupt.
Result<std::vector<DuplicatePair>> read_duplicates(const std::filesystem::path& out, DuplicatePolicy keep);
// The columns of the cells, in the order in which tile files have them.
std::vector<Attribute> cell_schema_of(const Manifest& manifest);
// Of all vertices; nothing when no tile tells any.
std::optional<HeightRange> heights_of(const Manifest& manifest);

}  // namespace tessera

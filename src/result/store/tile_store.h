// The result folder: tile files, master file and manifest. FORMAT.md specifies them.
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

// What the manifest says of a tile file.
struct TileEntry {
  TileId tile;
  TileKind kind = TileKind::cells;  // of the file
  std::uint64_t points = 0;         // vertices in the file, foreign ones included
  std::uint64_t own_points = 0;
  std::uint64_t cells = 0;  // cells in the file, or cells that follow from its points
  std::uint64_t main_cells = 0;
  std::uint64_t bytes = 0;
  std::uint32_t version = 1;     // the version of the result that wrote the file
  std::uint64_t xxh3 = 0;        // checksum of the file: see data_sum_of()
  std::optional<Digest> digest;  // of main cells and own vertices; older programs wrote none
  // 2D: the range of the finite values of the attribute z of the own vertices. Older programs wrote none.
  std::optional<HeightRange> heights = {};
  friend bool operator==(const TileEntry&, const TileEntry&) = default;
};

// The tile's file in a result folder.
inline std::filesystem::path tile_file(const std::filesystem::path& out, const TileEntry& entry) {
  return tile_file(out, entry.tile, entry.version, entry.kind);
}

// How the checksums of tile files and of duplicates.bin are computed in a folder of this format.
constexpr ChecksumOf data_sum_of(int format) { return format < 3 ? ChecksumOf::bytes : ChecksumOf::pieces; }

struct EarlyCells;      // early_cells.h
struct PointsTileView;  // points_tile.h

struct StoreOptions {
  bool neighbors = true;
  std::vector<Attribute> schema = {};    // of the rows that write_tile() gets
  std::filesystem::path lock_file = {};  // of the lock of OUT, for check_held()
  NodeId node = {};                      // the node that stores the tile
  bool sync = false;                     // sync the tile before it is reported as stored
  std::stop_token stop = {};             // once it is requested, write_tile() soon throws Stopped, and leaves nothing
};

// Writes OUT/tiles/NNNNNN.vtu under a temporary name, and computes its checksum and digest. `rows` has
// mesh.points.size() rows of the schema. When `cells` is given, it replaces `cells` and `neighbors` of the mesh, which
// are not read. `early` describes cells that are in the file already and that `cells` leaves out. Safe to call from
// several threads for different tiles.
Result<TileEntry> write_tile(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                             std::span<const std::byte> rows, const StoreOptions& options);
Result<TileEntry> write_tile(const std::filesystem::path& out, TileId tile, const TileMesh& mesh,
                             const CellStream& cells, std::span<const std::byte> rows, const StoreOptions& options,
                             const EarlyCells* early = nullptr);
// Writes OUT/tiles/NNNNNN.pts: the tile's own points in Hilbert order, and the foreign vertices of its cells. The cells
// follow from these points. `counted` has the counts and the digest of the cells, which are kept nowhere.
struct CountedCells {
  std::uint64_t cells = 0, main_cells = 0;
  Digest digest;  // of the main cells
};
Result<TileEntry> write_points_tile(const std::filesystem::path& out, const PointsTileView& tile,
                                    const CountedCells& counted, const StoreOptions& options);
// write_tile() and write_points_tile() also add a line to the node's file OUT/tiles/node-NNNNNN.done: the entry and its
// XXH3-64. By these lines a resumed run knows which tiles are stored; finish_store() removes the file. All tiles share
// a file, because creating a file takes longer than writing the line. stored_tiles() reads the file of each tile for
// which `wanted` returns true (by default all) once. It leaves out tiles whose file is not what was stored, or whose
// line is damaged; these tiles are made again.
Result<std::vector<TileEntry>> stored_tiles(const std::filesystem::path& out,
                                            const std::function<bool(TileId)>& wanted = {});

// Converts an entry to bytes for another node, and back. Returns nothing when the bytes are no entry or are damaged.
BigVector<std::byte> bytes_of(const TileEntry& entry);
std::optional<TileEntry> tile_entry_of(std::span<const std::byte> bytes);

// A tile as it was stored, as TileSource reads it.
struct StoredTile {
  TileMesh mesh;
  std::vector<Attribute> schema;
  std::vector<std::byte> rows;
  std::vector<Attribute> cell_schema;
  std::vector<std::vector<std::byte>> cell_columns;  // by column, then by cell; empty if not asked for
};

// A column that was computed from a result and added to it.
struct ResultColumn {
  std::string name;
  bool of_cells = false;  // else of vertices; then the schema has the column, too
  AttributeType type = AttributeType::f64;
  std::string unit;                  // of the values; "" when unknown
  std::uint32_t version = 2;         // the version of the result that the column came with
  std::vector<std::string> command;  // that made the column
  std::string software_version;      // of the tessera that made the column
  std::optional<double> total = {};  // over all cells or vertices, each once; only if a total makes sense
  friend bool operator==(const ResultColumn&, const ResultColumn&) = default;
};

struct Manifest {
  int format_version = unchanged_format;  // of the folder
  std::uint32_t version = 1;              // of the result: each change adds one (src/result/new_version.h)
  std::string software_version;
  std::vector<std::string> command;
  struct Input {
    std::string path;
    std::uint64_t bytes = 0;
    std::int64_t modified_ns = 0;
    // The source indices of its points, those that were filtered or invalid included. Older programs wrote none.
    struct Ids {
      std::uint64_t first = 0, count = 0;
      friend bool operator==(const Ids&, const Ids&) = default;
    };
    std::optional<Ids> ids = {};
  };
  std::vector<Input> inputs;
  int dimension = 3;
  std::string crs;
  std::string unit;  // of the coordinates, as the input stated it; "" when unknown
  std::string partition_kind;
  std::vector<Box> boxes;  // by tile id
  // As Partition::to_json() returned it, for Partition::from_json(). The partition gives tile_of() of the result.
  std::string partition;
  Bounds bounds;
  // Set when the tiles are not a whole triangulation, but the cells of one that meet a closed box.
  struct Region {
    Box box;
    bool complete = true;  // exactly these cells; else the tiles say which cells are final
  };
  std::optional<Region> region;
  bool neighbors = true;
  std::vector<Attribute> schema;
  std::vector<ResultColumn> columns;  // those of vertices are the last attributes of the schema
  std::vector<TileEntry> tiles;       // of non-empty tiles, by tile id
  std::uint64_t points_read = 0, invalid = 0, filtered = 0, duplicates = 0, vertices = 0, cells = 0;
  DuplicatePolicy keep = DuplicatePolicy::first;  // which of equal points is the vertex
  std::optional<std::uint64_t> other_heights;     // 2D: duplicates not at the kept point's height, if heights are known
  std::optional<Digest> digest;                   // sum of the digests of the tiles; nothing when a tile has none
  std::uint64_t duplicates_xxh3 = 0;              // of duplicates.bin; 0 when there is none
  std::uint64_t duplicate_rows_xxh3 = 0;          // of the attributes of the duplicates; 0 when they are not kept
  std::uint64_t master_xxh3 = 0;                  // of the master file
  // of the version before, whose master file may remain until the next change
  std::optional<std::uint64_t> previous_master_xxh3 = {};
  std::map<std::string, double> seconds;  // by phase
  std::map<std::string, double> figures;  // messages, peak memory, ...: for people, not for programs
};

struct DuplicatePair {
  PointId duplicate, kept;
  friend auto operator<=>(const DuplicatePair&, const DuplicatePair&) = default;
};
// The pairs may not fit into memory.
using DuplicateSort = ExternalSort<DuplicatePair>;
class DuplicateRowSort;  // duplicate_rows.h

// Writes triangulation.pvtu (which names the tiles), duplicates.bin when `duplicates` is not empty, then also the
// attributes of the duplicates when `rows` has them, and the manifest last. Sets in the manifest: digest, checksums,
// number of duplicates, and the schema's names as they are stored. Then calls `before_manifest`, which may add to the
// manifest, and may write files that must exist before the manifest does.
Status finish_store(
    const std::filesystem::path& out, Manifest& manifest, DuplicateSort& duplicates,
    const std::function<Status()>& before_manifest = [] { return success(); }, DuplicateRowSort* rows = nullptr);
// The same with pairs that are in memory.
Status finish_store(const std::filesystem::path& out, Manifest& manifest, std::span<const DuplicatePair> duplicates,
                    DuplicateRowSort* rows = nullptr);
// Removes what runs may have left in a finished result: side files, and files that were being written.
void remove_side_files(const std::filesystem::path& out);
// Errors: io when there is no manifest; corrupt when it is damaged or from a future version.
Result<Manifest> read_manifest(const std::filesystem::path& out);
// The error of a folder without a manifest.
Error no_manifest(const std::filesystem::path& out);
// Parses the bytes of a manifest; `path` is for errors.
Result<Manifest> parse_manifest(const std::filesystem::path& path, std::span<const std::byte> bytes);
// The file of the duplicates, which exists if the manifest has a checksum of it.
std::filesystem::path duplicates_of(const std::filesystem::path& out, const Manifest& manifest);
// The same for the file of their attributes.
std::filesystem::path duplicate_rows_of(const std::filesystem::path& out, const Manifest& manifest);
// Reads the duplicates of the version of a result that the manifest describes. Error corrupt when the policy in the
// manifest cannot give such pairs.
Result<std::vector<DuplicatePair>> read_duplicates(const std::filesystem::path& out, const Manifest& manifest);
// The same of the bytes of the file; `path` is for errors.
Result<std::vector<DuplicatePair>> parse_duplicates(const std::filesystem::path& path, std::span<const std::byte> bytes,
                                                    DuplicatePolicy keep);
// The sum of the digests of the tiles; nothing when a tile has none.
std::optional<Digest> sum_of_digests(const std::vector<TileEntry>& tiles);
// The columns of the cells, in the order in which tile files have them.
std::vector<Attribute> cell_schema_of(const Manifest& manifest);
// The same manifest as if the result had no computed columns.
Manifest without_columns(Manifest manifest);
// The range of the heights of all vertices; nothing when no tile has one.
std::optional<HeightRange> heights_of(const Manifest& manifest);

}  // namespace tessera

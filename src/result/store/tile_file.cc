// Writes a tile file: an XML header, then the arrays, from the first byte to the last, except for cells that were
// written early.
#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/base/image.h"
#include "src/base/stopped.h"
#include "src/result/store/direct_writer.h"
#include "src/result/store/early_cells.h"
#include "src/result/store/manifest.h"
#include "src/result/store/packed_array.h"
#include "src/result/store/tile_layout.h"
#include "src/result/store/tile_store.h"
#include "src/result/store/vtk_xml.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

namespace {

template <class List>
std::span<const std::byte> bytes_of(const List& values) {
  return std::as_bytes(std::span(values));
}

// Extracts the bytes `offset`..`offset + size` of each row of `stride` bytes.
std::vector<std::byte> column(std::span<const std::byte> rows, std::size_t stride, std::size_t offset,
                              std::size_t size) {
  const std::size_t n = rows.size() / stride;
  std::vector<std::byte> values(n * size);
  for (std::size_t i = 0; i < n; ++i) std::memcpy(values.data() + i * size, rows.data() + i * stride + offset, size);
  return values;
}

Error do_not_fit() { return error(Errc::internal, "a tile's arrays do not fit together"); }

Status check_mesh(const TileMesh& mesh, std::span<const std::byte> rows, const StoreOptions& options) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  const std::size_t n = mesh.points.size(), m = mesh.cell_ghost.size();
  const bool consistent =
      (mesh.dimension == 2 || mesh.dimension == 3) && mesh.ids.size() == n && mesh.owners.size() == n &&
      mesh.point_ghost.size() == n && (mesh.cell_final.empty() || mesh.cell_final.size() == m) &&
      (mesh.offsets.empty() || mesh.offsets.size() == n) && rows.size() == n * row_bytes(options.schema);
  if (!consistent) return do_not_fit();
  if (m * corners > std::numeric_limits<std::int32_t>::max() || n > std::numeric_limits<std::int32_t>::max())
    return error(Errc::memory, "a tile has more cells than 32-bit connectivity can hold: use smaller tiles");
  return success();
}

// The stream of cells of a mesh that has them as arrays.
class CellsOfMesh final : public CellStream {
 public:
  explicit CellsOfMesh(const TileMesh& mesh) : mesh_(mesh) {}
  Status vertices(const Consumer& take) const override { return take(mesh_.cells); }
  Status neighbors(const Consumer& take) const override { return take(mesh_.neighbors); }

 private:
  const TileMesh& mesh_;
};

// The offset of each vertex, three numbers each; empty when no vertex is an image.
std::vector<std::int8_t> offsets_of(const TileMesh& mesh) {
  std::vector<std::int8_t> offsets;
  offsets.reserve(3 * mesh.offsets.size());
  for (const std::uint8_t code : mesh.offsets) {
    for (const int periods : image::offset(code).by) offsets.push_back(static_cast<std::int8_t>(periods));
  }
  return offsets;
}

// All arrays, in the file's order. `columns` has the values of the attributes, in the order of the schema. `digest`
// gets the cells as they are written. The result refers to all arguments.
std::vector<PackedArray> pack(const TileHeader& header, const TileMesh& mesh, const CellStream& cells,
                              TileDigest& digest, const std::vector<std::vector<std::byte>>& columns,
                              std::span<const std::int8_t> images, std::uint64_t early, const std::stop_token& stop) {
  const std::uint8_t type = vtk_cell_type(mesh.dimension);
  const std::uint32_t tile = header.tile.value;
  std::vector<PackedArray> packed{PackedArray::plain(bytes_of(mesh.points)), PackedArray::plain(bytes_of(mesh.ids)),
                                  PackedArray::runs(bytes_of(mesh.owners), 4),
                                  PackedArray::runs(bytes_of(mesh.point_ghost), 1)};
  for (const auto& values : columns) packed.push_back(PackedArray::plain(values));
  const std::uint64_t row = 4 * (static_cast<std::uint64_t>(mesh.dimension) + 1);
  if (header.images) packed.push_back(PackedArray::runs(std::as_bytes(images), 1));
  packed.push_back(PackedArray::streamed(
      header.cells * row,
      [&](const PackedArray::Consumer& take) {
        return cells.vertices([&](std::span<const std::int32_t> piece) -> Status {
          BOOST_OUTCOME_TRYV(take(bytes_of(piece)));  // has no more cells than there are flags
          digest.add(piece);
          return success();
        });
      },
      early * row));
  packed.push_back(PackedArray::offsets(header.cells, mesh.dimension + 1, stop));
  packed.push_back(PackedArray::repeated(std::as_bytes(std::span(&type, 1)), header.cells));
  packed.push_back(PackedArray::runs(bytes_of(mesh.cell_ghost), 1));
  packed.push_back(PackedArray::repeated(std::as_bytes(std::span(&tile, 1)), header.cells));
  if (header.final) packed.push_back(PackedArray::runs(bytes_of(mesh.cell_final), 1));
  if (header.neighbors) {
    packed.push_back(PackedArray::streamed(
        header.cells * row,
        [&](const PackedArray::Consumer& take) {
          return cells.neighbors([&](std::span<const std::int32_t> piece) { return take(bytes_of(piece)); });
        },
        early * row));
  }
  return packed;
}

// Sets the header's offsets. Returns the header's size, from which offsets are counted.
std::uint64_t place(TileHeader& header, const std::vector<PackedArray>& arrays, const EarlyCells* early) {
  std::uint64_t at = 0, begin = 0;
  const auto infos = header.arrays();
  header.offsets.resize(arrays.size());
  if (early) {
    const EarlyOffsets offsets = early_offsets(header, early->room);
    const std::uint64_t row = 4 * (static_cast<std::uint64_t>(header.dimension) + 1);
    const std::uint64_t table = table_bytes(block_count(header.cells * row));
    begin = offsets.header_bytes;
    header.offsets[connectivity_of(infos)] = offsets.cells - table - begin;
    if (header.neighbors) header.offsets[neighbors_of(infos)] = offsets.neighbors - table - begin;
    at = offsets.cells - begin + plain_bytes(header.cells * row);
  }
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    if (early && (i == connectivity_of(infos) || i == neighbors_of(infos))) continue;
    header.offsets[i] = at;
    at += arrays[i].file_bytes();
  }
  return begin > 0 ? begin : header_text(header).size();
}

Result<DirectWriter::Written> write_file(DirectWriter file, const std::string& header,
                                         const std::vector<std::uint64_t>& offsets,
                                         const std::vector<PackedArray>& arrays) {
  BOOST_OUTCOME_TRYV(file.append(bytes_of(header)));
  std::vector<std::size_t> order(arrays.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return offsets[i]; });
  for (const std::size_t i : order) {
    BOOST_OUTCOME_TRYV(arrays[i].write(file, header.size() + offsets[i]));
  }
  BOOST_OUTCOME_TRYV(file.append(bytes_of(footer)));
  return file.finish();
}

// Returns early cells with room for all cells of the tile.
Result<EarlyCells> roomy(const fs::path& out, const TileHeader& header, const EarlyCells& early,
                         const StoreOptions& options) {
  if (header.cells <= early.room) return early;
  return with_room(out, header, early, header.cells, options);
}

std::optional<HeightRange> heights_of(const TileMesh& mesh, const std::vector<Attribute>& schema,
                                      const std::vector<std::vector<std::byte>>& columns) {
  const auto z = std::find(schema.begin(), schema.end(), Attribute{"z", AttributeType::f64});
  if (mesh.dimension != 2 || z == schema.end()) return std::nullopt;
  const auto& column = columns[static_cast<std::size_t>(z - schema.begin())];
  std::optional<HeightRange> range;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    double height = 0;
    std::memcpy(&height, column.data() + i * sizeof height, sizeof height);
    if (mesh.point_ghost[i] == 0) store::widen(range, height);
  }
  return range;
}

}  // namespace

void store::widen(std::optional<HeightRange>& range, double height) {
  if (!std::isfinite(height)) return;
  if (!range) range = HeightRange{height, height};
  range = HeightRange{std::min(range->lo, height), std::max(range->hi, height)};
}

// Does not sync: finish_store() syncs all tiles at once. If a power cut destroys a tile before, its file differs from
// what its side file says.
Status store::publish_tile(const fs::path& out, TemporaryFile& temporary, const TileEntry& entry,
                           const StoreOptions& options) {
  const fs::path final_name = tile_file(out, entry);
  BOOST_OUTCOME_TRYV(check_held(options.lock_file));
  BOOST_OUTCOME_TRYV(options.sync ? publish(temporary.path(), final_name) : rename_file(temporary.path(), final_name));
  temporary.keep();
  if (options.sync) {
    BOOST_OUTCOME_TRYV(sync_folder(final_name.parent_path()));
  }
  return write_done(out, options.node, entry);
}

Result<TileEntry> write_tile(const fs::path& out, TileId tile, const TileMesh& mesh, std::span<const std::byte> rows,
                             const StoreOptions& options) {
  const std::size_t numbers = mesh.cell_ghost.size() * (static_cast<std::size_t>(mesh.dimension) + 1);
  if (mesh.cells.size() != numbers || (options.neighbors && mesh.neighbors.size() != numbers)) return do_not_fit();
  return write_tile(out, tile, mesh, CellsOfMesh(mesh), rows, options);
}

Result<TileEntry> write_tile(const fs::path& out, TileId tile, const TileMesh& mesh, const CellStream& cells,
                             std::span<const std::byte> rows, const StoreOptions& options, const EarlyCells* begun) {
  BOOST_OUTCOME_TRY(schema, stored_schema(options.schema));
  BOOST_OUTCOME_TRYV(check_mesh(mesh, rows, options));
  const fs::path final_name = tile_file(out, tile);
  BOOST_OUTCOME_TRYV(make_directories(final_name.parent_path()));

  const std::size_t stride = row_bytes(schema);
  std::vector<std::vector<std::byte>> columns;
  for (std::size_t i = 0, offset = 0; i < schema.size(); offset += size_of(schema[i].type), ++i)
    columns.push_back(column(rows, stride, offset, size_of(schema[i].type)));

  TileHeader header{.dimension = mesh.dimension,
                    .tile = tile,
                    .points = mesh.points.size(),
                    .cells = mesh.cell_ghost.size(),
                    .final = !mesh.cell_final.empty(),
                    .neighbors = options.neighbors,
                    .schema = std::move(schema),
                    .images = !mesh.offsets.empty(),
                    .offsets = {}};
  const auto images = offsets_of(mesh);
  EarlyCells early;
  if (begun) {
    BOOST_OUTCOME_TRY(found, roomy(out, header, *begun, options));
    early = std::move(found);
  }
  TileDigest digest(mesh, early.cells, early.digest);
  const auto arrays = pack(header, mesh, cells, digest, columns, images, early.cells, options.stop);
  const std::uint64_t header_bytes = place(header, arrays, begun ? &early : nullptr);

  TileEntry entry;
  entry.tile = tile;
  entry.points = header.points;
  entry.own_points = static_cast<std::uint64_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
  entry.cells = header.cells;
  entry.main_cells = static_cast<std::uint64_t>(std::count(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0));
  throw_if_stopped(options.stop);
  TemporaryFile temporary(begun ? early_file(out, tile, early.node) : temporary_name_of_process(final_name));
  BOOST_OUTCOME_TRY(file, begun ? DirectWriter::go_on(temporary.path(), final_name, early.begun, options.stop)
                                : DirectWriter::create(temporary.path(), final_name, options.stop));
  BOOST_OUTCOME_TRY(written, write_file(std::move(file), header_text(header, header_bytes), header.offsets, arrays));
  entry.digest = digest.value();
  entry.heights = heights_of(mesh, header.schema, columns);
  entry.bytes = written.bytes;
  entry.xxh3 = written.xxh3;
  BOOST_OUTCOME_TRYV(publish_tile(out, temporary, entry, options));
  return entry;
}

}  // namespace tessera

// Writes one tile. HDF5 lays the file out in memory, where the places of the big arrays (H5Dget_offset) are holes; what
// it wrote around them and the arrays themselves then go to disk without it, outside its global lock, so that several
// threads write at the same time.
#include <algorithm>
#include <cstring>
#include <limits>

#include "src/base/check.h"
#include "src/store/direct_writer.h"
#include "src/store/files.h"
#include "src/store/hdf5_handle.h"
#include "src/store/manifest.h"
#include "src/store/offset_chunks.h"
#include "src/store/sync_queue.h"
#include "src/store/tile_layout.h"
#include "src/store/tile_store.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

namespace {

// A big array and its place in the file.
struct Region {
  std::uint64_t offset = 0;
  std::span<const std::byte> bytes;
};

std::vector<hsize_t> shape_of(const ArrayInfo& array, std::uint64_t points, std::uint64_t cells, int dimension) {
  hsize_t rows = 0;
  switch (array.rows) {
    case ArrayOf::points:
      rows = points;
      break;
    case ArrayOf::cells:
      rows = cells;
      break;
    case ArrayOf::cells_plus_one:
      rows = cells + 1;
      break;
    case ArrayOf::connectivity:
      rows = cells * static_cast<hsize_t>(dimension + 1);
      break;
  }
  return array.columns == 1 ? std::vector<hsize_t>{rows} : std::vector<hsize_t>{rows, array.columns};
}

// Empty when HDF5 refused; hdf5_reason() then tells.
bool create_bulk(hid_t group, const ArrayInfo& array, const std::vector<hsize_t>& shape,
                 std::span<const std::byte> bytes, std::vector<Region>& regions) {
  const Hdf5Handle properties = dataset_properties();
  H5Pset_layout(properties, H5D_CONTIGUOUS);
  H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER);
  const Hdf5Handle space = space_of(shape);
  const Hdf5Handle dataset{
      H5Dcreate2(group, array.name.c_str(), hdf5_type(array.type), space, H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose};
  if (!dataset.ok()) return false;
  if (bytes.empty()) return true;
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) return false;
  regions.push_back({offset, bytes});
  return true;
}

// 0, s, 2s, ...: a few hundred bytes a chunk.
bool create_offsets(hid_t group, std::uint64_t cells, int step) {
  const hsize_t entries = cells + 1;
  const hsize_t chunk = std::min<hsize_t>(entries, offsets_per_chunk);
  const Hdf5Handle properties = dataset_properties();
  H5Pset_chunk(properties, 1, &chunk);
  H5Pset_shuffle(properties);
  H5Pset_deflate(properties, 1);
  const Hdf5Handle space = space_of({entries});
  const Hdf5Handle dataset{H5Dcreate2(group, "Offsets", H5T_STD_I32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT),
                           H5Dclose};
  if (!dataset.ok()) return false;
  for (hsize_t first = 0; first < entries; first += chunk) {
    const auto packed = offsets_chunk(first, chunk, step);
    if (H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, &first, packed->size(), packed->data()) < 0) return false;
  }
  return true;
}

// No chunk is ever written: every entry is the fill value.
bool create_types(hid_t group, std::uint64_t cells, std::uint8_t type) {
  const Hdf5Handle properties = dataset_properties();
  const hsize_t chunk = std::min<hsize_t>(cells, hsize_t{1} << 20);
  if (chunk > 0) H5Pset_chunk(properties, 1, &chunk);
  H5Pset_fill_value(properties, H5T_NATIVE_UINT8, &type);
  const Hdf5Handle space = space_of({cells});
  const Hdf5Handle dataset{H5Dcreate2(group, "Types", H5T_STD_U8LE, space, H5P_DEFAULT, properties, H5P_DEFAULT),
                           H5Dclose};
  return dataset.ok();
}

template <class List>
std::span<const std::byte> bytes_of(const List& values) {
  return std::as_bytes(std::span(values));
}

// Column `offset`..`offset + size` of rows of `stride` bytes.
std::vector<std::byte> column(std::span<const std::byte> rows, std::size_t stride, std::size_t offset,
                              std::size_t size) {
  const std::size_t n = rows.size() / stride;
  std::vector<std::byte> values(n * size);
  for (std::size_t i = 0; i < n; ++i) std::memcpy(values.data() + i * size, rows.data() + i * stride + offset, size);
  return values;
}

Status check_mesh(const TileMesh& mesh, std::span<const std::byte> rows, const StoreOptions& options) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  const std::size_t n = mesh.points.size(), m = mesh.cell_ghost.size();
  const bool consistent = (mesh.dimension == 2 || mesh.dimension == 3) && mesh.ids.size() == n &&
                          mesh.point_ghost.size() == n && mesh.cells.size() == m * corners &&
                          (!options.neighbors || mesh.neighbors.size() == m * corners) &&
                          rows.size() == n * row_bytes(options.schema);
  if (!consistent) return error(Errc::internal, "a tile's arrays do not fit together");
  if (mesh.cells.size() > std::numeric_limits<std::int32_t>::max() || n > std::numeric_limits<std::int32_t>::max())
    return error(Errc::memory, "a tile has more cells than 32-bit connectivity can hold: use smaller tiles");
  return success();
}

Result<std::vector<Region>> lay_out(const fs::path& temporary, const MemoryFile& layout, const fs::path& final_name,
                                    const TileMesh& mesh, const std::vector<Attribute>& schema, bool neighbors,
                                    const std::vector<std::vector<std::byte>>& columns) {
  const std::uint64_t n = mesh.points.size(), m = mesh.cell_ghost.size();
  const auto refused = [&] { return error(Errc::io, final_name.string() + ": cannot write: " + hdf5_reason()); };
  VtkHdfFile out = create_vtkhdf(temporary.string(), layout);
  if (!out.ok()) return refused();
  if (!write_counts(out.group, "NumberOfPoints", {static_cast<std::int64_t>(n)}) ||
      !write_counts(out.group, "NumberOfCells", {static_cast<std::int64_t>(m)}) ||
      !write_counts(out.group, "NumberOfConnectivityIds", {static_cast<std::int64_t>(mesh.cells.size())}))
    return refused();

  std::vector<Region> regions;
  std::size_t next_column = 0;
  for (const auto& array : tile_arrays(mesh.dimension, neighbors, schema)) {
    const auto shape = shape_of(array, n, m, mesh.dimension);
    bool made = false;
    if (array.name == "Offsets") {
      made = create_offsets(out.group, m, mesh.dimension + 1);
    } else if (array.name == "Types") {
      made = create_types(out.group, m, vtk_cell_type(mesh.dimension));
    } else {
      const auto bytes = array.name == "Points"                   ? bytes_of(mesh.points)
                         : array.name == "Connectivity"           ? bytes_of(mesh.cells)
                         : array.name == "PointData/id"           ? bytes_of(mesh.ids)
                         : array.name == "PointData/vtkGhostType" ? bytes_of(mesh.point_ghost)
                         : array.name == "CellData/vtkGhostType"  ? bytes_of(mesh.cell_ghost)
                         : array.name == "CellData/neighbors"     ? bytes_of(mesh.neighbors)
                                                                  : bytes_of(columns[next_column++]);
      made = create_bulk(out.group, array, shape, bytes, regions);
    }
    if (!made) return refused();
  }
  out.cell_data.close();
  out.point_data.close();
  out.group.close();
  if (!out.file.close()) return refused();
  std::sort(regions.begin(), regions.end(), [](const Region& a, const Region& b) { return a.offset < b.offset; });
  return regions;
}

// What HDF5 wrote around the big arrays, and these: the whole file in order. `around` keeps HDF5's bytes alive.
Result<std::vector<Region>> fill_gaps(const MemoryFile& layout, const std::vector<Region>& bulk,
                                      std::vector<std::vector<std::byte>>& around) {
  std::vector<Region> whole;
  std::uint64_t at = 0;
  BOOST_OUTCOME_TRY(size, layout.size());
  const auto read_until = [&](std::uint64_t end) -> Status {
    check(end >= at, "HDF5 laid two arrays over each other");
    if (end == at) return success();
    BOOST_OUTCOME_TRY(bytes, layout.read(at, end));
    around.push_back(std::move(bytes));
    whole.push_back({at, around.back()});
    return success();
  };
  for (const auto& region : bulk) {
    BOOST_OUTCOME_TRYV(read_until(region.offset));
    whole.push_back(region);
    at = region.offset + region.bytes.size();
  }
  BOOST_OUTCOME_TRYV(read_until(std::max(size, at)));
  return whole;
}

// Writes the file and tells its size and checksum.
Status write_regions(const std::vector<Region>& regions, const fs::path& temporary, const fs::path& final_name,
                     TileEntry& entry) {
  BOOST_OUTCOME_TRY(file, DirectWriter::open(temporary, final_name));
  for (const auto& region : regions) {
    BOOST_OUTCOME_TRYV(file.append(region.bytes));
  }
  BOOST_OUTCOME_TRY(written, file.finish());
  entry.bytes = written.bytes;
  entry.xxh3 = written.xxh3;
  return success();
}

}  // namespace

Result<TileEntry> write_tile(const fs::path& out, TileId tile, const TileMesh& mesh, std::span<const std::byte> rows,
                             const StoreOptions& options) {
  const QuietHdf5 quiet;
  BOOST_OUTCOME_TRYV(SyncQueue::instance().failed(out));
  BOOST_OUTCOME_TRYV(check_mesh(mesh, rows, options));
  BOOST_OUTCOME_TRY(schema, stored_schema(options.schema));
  const fs::path final_name = tile_file(out, tile);
  BOOST_OUTCOME_TRYV(make_directories(final_name.parent_path()));

  const std::size_t stride = row_bytes(schema);
  std::vector<std::vector<std::byte>> columns;
  for (std::size_t i = 0, offset = 0; i < schema.size(); offset += size_of(schema[i].type), ++i)
    columns.push_back(column(rows, stride, offset, size_of(schema[i].type)));

  const std::size_t n = mesh.points.size(), m = mesh.cell_ghost.size();
  const std::uint64_t bulk = n * (sizeof(Point) + 9 + stride) + mesh.cells.size() * (options.neighbors ? 8 : 4) + m;
  TemporaryFile temporary(temporary_name(final_name));
  BOOST_OUTCOME_TRY(layout, MemoryFile::create(bulk + (std::uint64_t{1} << 20), final_name));
  BOOST_OUTCOME_TRY(bulk_regions,
                    lay_out(temporary.path(), layout, final_name, mesh, schema, options.neighbors, columns));
  std::vector<std::vector<std::byte>> around;
  around.reserve(bulk_regions.size() + 1);
  BOOST_OUTCOME_TRY(regions, fill_gaps(layout, bulk_regions, around));

  TileEntry entry;
  entry.tile = tile.value;
  entry.points = n;
  entry.own_points = static_cast<std::uint64_t>(std::count(mesh.point_ghost.begin(), mesh.point_ghost.end(), 0));
  entry.cells = m;
  entry.main_cells = static_cast<std::uint64_t>(std::count(mesh.cell_ghost.begin(), mesh.cell_ghost.end(), 0));
  BOOST_OUTCOME_TRYV(write_regions(regions, temporary.path(), final_name, entry));
  SyncQueue::instance().push(out, std::move(temporary), entry);
  return entry;
}

}  // namespace tessera

// The master file: virtual datasets over the tile files, one VTKHDF partition a tile. It holds no data of its own.
#include "src/store/files.h"
#include "src/store/hdf5_handle.h"
#include "src/store/manifest.h"
#include "src/store/tile_layout.h"

namespace tessera::store {

namespace {

hsize_t rows_of(const ArrayInfo& array, const TileEntry& entry, int dimension) {
  switch (array.rows) {
    case ArrayOf::points:
      return entry.points;
    case ArrayOf::cells:
      return entry.cells;
    case ArrayOf::cells_plus_one:
      return entry.cells + 1;
    case ArrayOf::connectivity:
      return entry.cells * static_cast<hsize_t>(dimension + 1);
  }
  return 0;
}

// HDF5 takes % in the name of a source for the start of a pattern, and %% for %.
std::string without_patterns(const std::string& name) {
  std::string result;
  for (const char c : name) result += c == '%' ? "%%" : std::string(1, c);
  return result;
}

bool create_virtual(hid_t group, const ArrayInfo& array, const Manifest& manifest) {
  const auto shape = [&](hsize_t rows) {
    return array.columns == 1 ? std::vector<hsize_t>{rows} : std::vector<hsize_t>{rows, array.columns};
  };
  hsize_t total = 0;
  for (const auto& entry : manifest.tiles) total += rows_of(array, entry, manifest.dimension);

  const Hdf5Handle properties = dataset_properties();
  const std::uint8_t type = vtk_cell_type(manifest.dimension);
  if (array.name == "Types") H5Pset_fill_value(properties, H5T_NATIVE_UINT8, &type);
  const Hdf5Handle space = space_of(shape(total));
  hsize_t first = 0;
  for (const auto& entry : manifest.tiles) {
    const hsize_t rows = rows_of(array, entry, manifest.dimension);
    if (rows == 0) continue;
    const std::vector<hsize_t> start =
        array.columns == 1 ? std::vector<hsize_t>{first} : std::vector<hsize_t>{first, 0};
    const auto count = shape(rows);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
    const Hdf5Handle source = space_of(count);
    // Relative names: HDF5 looks beside the master file, so the folder can be moved.
    const std::string file = tile_file("", TileId{entry.tile}).generic_string();
    const std::string dataset = without_patterns("/VTKHDF/" + array.name);
    if (H5Pset_virtual(properties, space, file.c_str(), dataset.c_str(), source) < 0) return false;
    first += rows;
  }
  const Hdf5Handle whole = space_of(shape(total));
  const Hdf5Handle dataset{
      H5Dcreate2(group, array.name.c_str(), hdf5_type(array.type), whole, H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose};
  return dataset.ok();
}

}  // namespace

Result<std::vector<std::byte>> make_master(const std::filesystem::path& path, const Manifest& manifest) {
  const QuietHdf5 quiet;
  const auto refused = [&] { return error(Errc::io, path.string() + ": cannot write: " + hdf5_reason()); };
  // Names and places of the sources: about a hundred bytes a tile and array.
  const std::uint64_t arrays = 8 + manifest.schema.size();
  BOOST_OUTCOME_TRY(memory, MemoryFile::create((arrays * 512 * (manifest.tiles.size() + 16)) + (1 << 20), path));
  const TemporaryFile temporary(temporary_name(path));
  VtkHdfFile out = create_vtkhdf(temporary.path().string(), memory);
  if (!out.ok()) return refused();
  std::vector<std::int64_t> points, cells, connectivity;
  for (const auto& entry : manifest.tiles) {
    points.push_back(static_cast<std::int64_t>(entry.points));
    cells.push_back(static_cast<std::int64_t>(entry.cells));
    connectivity.push_back(static_cast<std::int64_t>(entry.cells) * (manifest.dimension + 1));
  }
  if (!write_counts(out.group, "NumberOfPoints", points) || !write_counts(out.group, "NumberOfCells", cells) ||
      !write_counts(out.group, "NumberOfConnectivityIds", connectivity))
    return refused();
  for (const auto& array : tile_arrays(manifest.dimension, manifest.neighbors, manifest.schema))
    if (!create_virtual(out.group, array, manifest)) return refused();
  out.cell_data.close();
  out.point_data.close();
  out.group.close();
  if (!out.file.close()) return refused();
  BOOST_OUTCOME_TRY(size, memory.size());
  return memory.read(0, size);
}

}  // namespace tessera::store

// Nothing in the file is believed: an array is allocated only after its size was compared with the size of the file,
// and every value that others will use as an index is checked.
#include "src/store/format1_reader.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include "src/files/there.h"
#include "src/store/hdf5_handle.h"
#include "src/store/mesh_checks.h"
#include "src/store/tile_layout.h"

namespace tessera::store {

namespace fs = std::filesystem;

namespace {

class TileReader {
 public:
  explicit TileReader(fs::path path) : path_(std::move(path)) {}

  Result<StoredTile> read(bool with_cells, bool with_rows) {
    BOOST_OUTCOME_TRYV(open());
    StoredTile tile;
    TileMesh& mesh = tile.mesh;
    BOOST_OUTCOME_TRYV(read_dimension(mesh));
    BOOST_OUTCOME_TRYV(read_vertices(mesh));
    if (with_cells) {
      BOOST_OUTCOME_TRYV(read_cells(mesh));
    }
    BOOST_OUTCOME_TRYV(check_values(mesh, [this](const auto& place, const auto& reason) {
      return corrupt(place == "Cells/connectivity" ? "Connectivity" : place, reason);
    }));
    BOOST_OUTCOME_TRYV(read_schema(tile.schema));
    if (with_rows) {
      BOOST_OUTCOME_TRYV(read_rows(mesh.points.size(), tile));
    }
    return tile;
  }

 private:
  Status read_vertices(TileMesh& mesh) const {
    static_assert(sizeof(Point) == 3 * sizeof(double));
    BOOST_OUTCOME_TRY(dims, shape("Points", AttributeType::f64));
    if (dims.size() != 2 || dims[1] != 3) return corrupt("Points", "is not an array of 3 columns");
    const hsize_t n = dims[0];
    BOOST_OUTCOME_TRYV(read_array("Points", AttributeType::f64, {n, 3}, mesh.points));
    BOOST_OUTCOME_TRYV(read_array("PointData/id", AttributeType::u64, {n}, mesh.ids));
    BOOST_OUTCOME_TRYV(read_array("PointData/vtkGhostType", AttributeType::u8, {n}, mesh.point_ghost));
    return check_count("NumberOfPoints", n);
  }

  Status read_cells(TileMesh& mesh) const {
    const auto corners = static_cast<hsize_t>(mesh.dimension + 1);
    BOOST_OUTCOME_TRY(dims, shape("CellData/vtkGhostType", AttributeType::u8));
    if (dims.size() != 1) return corrupt("CellData/vtkGhostType", "is not a list");
    const hsize_t m = dims[0];
    BOOST_OUTCOME_TRYV(read_array("CellData/vtkGhostType", AttributeType::u8, {m}, mesh.cell_ghost));
    BOOST_OUTCOME_TRYV(read_array("Connectivity", AttributeType::i32, {m * corners}, mesh.cells));
    if (H5Lexists(group_, "CellData/neighbors", H5P_DEFAULT) > 0) {
      BOOST_OUTCOME_TRYV(read_array("CellData/neighbors", AttributeType::i32, {m, corners}, mesh.neighbors));
    }
    return check_constant_arrays(mesh, m);
  }

  Error corrupt(const std::string& place, const std::string& reason) const {
    return error(Errc::corrupt, path_.string() + ", /VTKHDF/" + place + ": " + reason);
  }

  Status open() {
    BOOST_OUTCOME_TRY(bytes, file_bytes(path_));
    bytes_ = bytes;
    file_ = {H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
    if (!file_.ok())
      return error(Errc::corrupt, path_.string() + ": is not a tile file, or damaged (" + hdf5_reason() + ")");
    group_ = {H5Gopen2(file_, "VTKHDF", H5P_DEFAULT), H5Gclose};
    if (!group_.ok()) return error(Errc::corrupt, path_.string() + ": has no group /VTKHDF");
    return success();
  }

  static std::optional<AttributeType> type_of(hid_t dataset) {
    const Hdf5Handle type{H5Dget_type(dataset), H5Tclose};
    for (const auto candidate :
         {AttributeType::u8, AttributeType::i8, AttributeType::u16, AttributeType::i16, AttributeType::u32,
          AttributeType::i32, AttributeType::u64, AttributeType::i64, AttributeType::f32, AttributeType::f64})
      if (H5Tequal(type, hdf5_type(candidate)) > 0) return candidate;
    return std::nullopt;
  }

  Result<Hdf5Handle> open_array(const std::string& name) const {
    if (H5Lexists(group_, name.substr(0, name.find('/')).c_str(), H5P_DEFAULT) <= 0 ||
        H5Lexists(group_, name.c_str(), H5P_DEFAULT) <= 0)
      return corrupt(name, "is missing");
    Hdf5Handle dataset{H5Dopen2(group_, name.c_str(), H5P_DEFAULT), H5Dclose};
    if (!dataset.ok()) return corrupt(name, "cannot be opened (" + hdf5_reason() + ")");
    return dataset;
  }

  Result<std::vector<hsize_t>> shape(const std::string& name, AttributeType type) const {
    BOOST_OUTCOME_TRY(dataset, open_array(name));
    return shape(dataset, name, type);
  }

  Result<std::vector<hsize_t>> shape(hid_t dataset, const std::string& name, AttributeType type) const {
    if (type_of(dataset) != type) return corrupt(name, "has the wrong type");
    const Hdf5Handle space{H5Dget_space(dataset), H5Sclose};
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank != 1 && rank != 2) return corrupt(name, "has the wrong number of dimensions");
    std::vector<hsize_t> dims(static_cast<std::size_t>(rank));
    H5Sget_simple_extent_dims(space, dims.data(), nullptr);
    return dims;
  }

  // `compressed`: the array may be larger than the file; the caller has bounded `wanted` by another array.
  template <class List>
  Status read_array(const std::string& name, AttributeType type, const std::vector<hsize_t>& wanted, List& values,
                    bool compressed = false) const {
    BOOST_OUTCOME_TRY(dataset, open_array(name));
    BOOST_OUTCOME_TRY(dims, shape(dataset, name, type));
    if (dims != wanted) return corrupt(name, "has the wrong length");
    hsize_t elements = 1;
    for (const auto extent : dims) {
      if (extent != 0 && elements > bytes_ * 64 / extent) return corrupt(name, "is larger than its file");
      elements *= extent;
    }
    const std::uint64_t size = elements * size_of(type);
    if (!compressed && size > bytes_) return corrupt(name, "is larger than its file");
    values.resize(size / sizeof(typename List::value_type));
    if (size > 0 && H5Dread(dataset, hdf5_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
      return corrupt(name, "cannot be read (" + hdf5_reason() + ")");
    return success();
  }

  // The fill value of Types tells triangles from tetrahedra, also when there is no cell.
  Status read_dimension(TileMesh& mesh) const {
    BOOST_OUTCOME_TRY(dataset, open_array("Types"));
    const Hdf5Handle properties{H5Dget_create_plist(dataset), H5Pclose};
    std::uint8_t type = 0;
    if (H5Pget_fill_value(properties, H5T_NATIVE_UINT8, &type) < 0) return corrupt("Types", "has no fill value");
    if (type == vtk_cell_type(2)) {
      mesh.dimension = 2;
    } else if (type == vtk_cell_type(3)) {
      mesh.dimension = 3;
    } else {
      return corrupt("Types", "is neither of triangles nor of tetrahedra");
    }
    return success();
  }

  Status check_count(const char* name, hsize_t wanted) const {
    std::vector<std::int64_t> count;
    BOOST_OUTCOME_TRYV(read_array(name, AttributeType::i64, {1}, count));
    if (count[0] < 0 || static_cast<hsize_t>(count[0]) != wanted)
      return corrupt(name, "does not agree with the arrays");
    return success();
  }

  Status check_constant_arrays(const TileMesh& mesh, hsize_t m) const {
    const auto corners = static_cast<std::size_t>(mesh.dimension + 1);
    BOOST_OUTCOME_TRYV(check_count("NumberOfCells", m));
    BOOST_OUTCOME_TRYV(check_count("NumberOfConnectivityIds", m * corners));
    std::vector<std::uint8_t> types;
    BOOST_OUTCOME_TRYV(read_array("Types", AttributeType::u8, {m}, types, true));
    for (std::size_t i = 0; i < types.size(); ++i)
      if (types[i] != vtk_cell_type(mesh.dimension))
        return corrupt("Types", "cell " + std::to_string(i) + " is of another type");
    std::vector<std::int32_t> offsets;
    BOOST_OUTCOME_TRYV(read_array("Offsets", AttributeType::i32, {m + 1}, offsets, true));
    for (std::size_t i = 0; i < offsets.size(); ++i)
      if (static_cast<std::uint64_t>(static_cast<std::int64_t>(offsets[i])) != i * corners)
        return corrupt("Offsets", "entry " + std::to_string(i) + " is not " + std::to_string(i * corners));
    return success();
  }

  Status read_schema(std::vector<Attribute>& schema) const {
    const Hdf5Handle group{H5Gopen2(group_, "PointData", H5P_DEFAULT), H5Gclose};
    if (!group.ok()) return corrupt("PointData", "is missing");
    std::vector<std::string> names;
    const auto take = [](hid_t, const char* name, const H5L_info_t*, void* data) -> herr_t {
      static_cast<std::vector<std::string>*>(data)->emplace_back(name);
      return 0;
    };
    if (H5Literate(group, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, take, &names) < 0)
      return corrupt("PointData", "cannot be listed (" + hdf5_reason() + ")");
    for (const auto& name : names) {
      if (name == "id" || name == "vtkGhostType") continue;
      BOOST_OUTCOME_TRY(dataset, open_array("PointData/" + name));
      const auto type = type_of(dataset);
      if (!type) return corrupt("PointData/" + name, "has a type that attributes never have");
      schema.push_back({name, *type});
    }
    return success();
  }

  Status read_rows(hsize_t n, StoredTile& tile) const {
    const std::size_t stride = row_bytes(tile.schema);
    if (n * stride > bytes_) return corrupt("PointData", "is larger than its file");
    tile.rows.resize(n * stride);
    std::size_t offset = 0;
    std::vector<std::byte> column;
    for (const auto& attribute : tile.schema) {
      const std::size_t size = size_of(attribute.type);
      BOOST_OUTCOME_TRYV(read_array("PointData/" + attribute.name, attribute.type, {n}, column));
      for (hsize_t i = 0; i < n; ++i)
        std::memcpy(tile.rows.data() + i * stride + offset, column.data() + i * size, size);
      offset += size;
    }
    return success();
  }

  fs::path path_;
  std::uint64_t bytes_ = 0;
  Hdf5Handle file_, group_;
};

}  // namespace

Result<StoredTile> read_format1_tile(const std::filesystem::path& path, bool with_cells, bool with_rows) {
  const QuietHdf5 quiet;
  return TileReader(path).read(with_cells, with_rows);
}

}  // namespace tessera::store

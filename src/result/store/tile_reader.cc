// Reads a tile file. Nothing in it is trusted: the header must be one that this program writes, arrays must not
// overlap, memory is taken only for what the file is large enough to hold, every block has a checksum, and every value
// that other code uses as an index is checked.
#include "src/result/store/tile_reader.h"

#include <cstring>
#include <string>
#include <utility>

#include "src/base/image.h"
#include "src/result/store/mesh_checks.h"
#include "src/result/store/packed_tile.h"
#include "src/result/store/tile_layout.h"

namespace tessera {

namespace fs = std::filesystem;
using namespace store;

namespace {

class TileReader {
 public:
  TileReader(PackedTile file, TileId tile) : file_(std::move(file)), tile_(tile) {}

  Result<StoredTile> read(const TileFields& fields) {
    StoredTile stored;
    TileMesh& mesh = stored.mesh;
    mesh.dimension = file_.header().dimension;
    stored.schema = file_.header().schema;
    stored.cell_schema = file_.header().cell_schema;
    BOOST_OUTCOME_TRYV(file_.read_array(Section::points, "Points", mesh.points));
    BOOST_OUTCOME_TRYV(file_.read_array(Section::point_data, "id", mesh.ids));
    BOOST_OUTCOME_TRYV(file_.read_array(Section::point_data, "owner", mesh.owners));
    BOOST_OUTCOME_TRYV(file_.read_array(Section::point_data, "vtkGhostType", mesh.point_ghost));
    if (file_.header().images) {
      BOOST_OUTCOME_TRYV(read_images(mesh));
    }
    if (fields.cells) {
      BOOST_OUTCOME_TRYV(file_.read_array(Section::cells, "connectivity", mesh.cells));
      BOOST_OUTCOME_TRYV(file_.read_array(Section::cell_data, "vtkGhostType", mesh.cell_ghost));
      if (file_.header().final) {
        BOOST_OUTCOME_TRYV(file_.read_array(Section::cell_data, "final", mesh.cell_final));
      }
      if (file_.header().neighbors) {
        BOOST_OUTCOME_TRYV(file_.read_array(Section::cell_data, "neighbors", mesh.neighbors));
      }
      BOOST_OUTCOME_TRYV(check_constant_arrays());
    }
    BOOST_OUTCOME_TRYV(check_values(
        mesh, [this](const std::string& place, const std::string& reason) { return file_.corrupt(place, reason); }));
    for (std::size_t i = 0; i < mesh.owners.size(); ++i)
      if ((mesh.owners[i] != tile_ || (!mesh.offsets.empty() && mesh.offsets[i] != 0)) != (mesh.point_ghost[i] != 0))
        return file_.corrupt("PointData/owner", "point " + std::to_string(i) + " of tile " + to_string(mesh.owners[i]) +
                                                    " has the wrong vtkGhostType");
    if (fields.cells && fields.cell_columns) {
      BOOST_OUTCOME_TRYV(read_cell_columns(stored));
    }
    if (fields.rows) {
      BOOST_OUTCOME_TRYV(read_rows(stored));
    }
    return stored;
  }

  Result<std::vector<PointId>> read_own_ids() {
    std::vector<PointId> ids;
    std::vector<std::uint8_t> ghost;
    BOOST_OUTCOME_TRYV(file_.read_array(Section::point_data, "id", ids));
    BOOST_OUTCOME_TRYV(file_.read_array(Section::point_data, "vtkGhostType", ghost));
    return own_of(std::move(ids), ghost);
  }

  static std::vector<PointId> own_of(std::vector<PointId> ids, const std::vector<std::uint8_t>& ghost) {
    std::size_t own = 0;
    for (std::size_t i = 0; i < ids.size(); ++i)
      if (ghost[i] == 0) ids[own++] = ids[i];
    ids.resize(own);
    return ids;
  }

 private:
  Status read_images(TileMesh& mesh) const {
    std::vector<std::int8_t> numbers;
    BOOST_OUTCOME_TRYV(file_.read_array(Section::point_data, images_array, numbers));
    for (std::size_t i = 0; i < numbers.size(); i += 3) {
      const PeriodOffset offset{{numbers[i], numbers[i + 1], numbers[i + 2]}};
      if (!offset.near())
        return file_.corrupt(std::string("PointData/") + images_array,
                             "point " + std::to_string(i / 3) + " lies more than one period away");
      mesh.offsets.push_back(static_cast<std::uint8_t>(image::code(offset)));
    }
    return success();
  }

  Status check_constant_arrays() const {
    const auto corners = static_cast<std::uint64_t>(file_.header().dimension + 1);
    std::vector<std::uint8_t> types;
    BOOST_OUTCOME_TRYV(file_.read_array(Section::cells, "types", types));
    for (std::size_t i = 0; i < types.size(); ++i)
      if (types[i] != vtk_cell_type(file_.header().dimension))
        return file_.corrupt("Cells/types", "cell " + std::to_string(i) + " is of another type");
    std::vector<std::int32_t> numbers;
    BOOST_OUTCOME_TRYV(file_.read_array(Section::cells, "offsets", numbers));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (numbers[i] < 0 || static_cast<std::uint64_t>(numbers[i]) != (i + 1) * corners)
        return file_.corrupt("Cells/offsets",
                             "entry " + std::to_string(i) + " is not " + std::to_string((i + 1) * corners));
    BOOST_OUTCOME_TRYV(file_.read_array(Section::cell_data, "tile", numbers));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (static_cast<std::uint32_t>(numbers[i]) != tile_.value)
        return file_.corrupt("CellData/tile", "cell " + std::to_string(i) + " is of another tile");
    return success();
  }

  Status read_rows(StoredTile& stored) const {
    const std::size_t stride = row_bytes(stored.schema), n = file_.header().points;
    stored.rows.resize(n * stride);
    std::size_t offset = 0;
    std::vector<std::byte> column;
    for (std::size_t k = 0; k < stored.schema.size(); ++k) {
      const std::size_t size = size_of(stored.schema[k].type);
      BOOST_OUTCOME_TRYV(file_.read_array(file_.arrays()[first_attribute + k], column));
      for (std::size_t i = 0; i < n; ++i)
        std::memcpy(stored.rows.data() + i * stride + offset, column.data() + i * size, size);
      offset += size;
    }
    return success();
  }

  // The columns of cells are the last arrays.
  Status read_cell_columns(StoredTile& stored) const {
    const auto& arrays = file_.arrays();
    for (std::size_t i = arrays.size() - stored.cell_schema.size(); i < arrays.size(); ++i) {
      BOOST_OUTCOME_TRYV(file_.read_array(arrays[i], stored.cell_columns.emplace_back()));
    }
    return success();
  }

  PackedTile file_;
  TileId tile_;
};

}  // namespace

namespace store {

Result<StoredTile> read_tile(DataFile file, TileId tile, const TileFields& fields) {
  BOOST_OUTCOME_TRY(opened, PackedTile::open(std::move(file), tile));
  return TileReader(std::move(opened), tile).read(fields);
}

Result<std::vector<PointId>> read_own_ids(DataFile file, TileId tile) {
  BOOST_OUTCOME_TRY(opened, PackedTile::open(std::move(file), tile));
  return TileReader(std::move(opened), tile).read_own_ids();
}

Result<StoredTile> read_tile(const fs::path& path, TileId tile, const TileFields& fields) {
  BOOST_OUTCOME_TRY(file, DataFile::open(path));
  return read_tile(std::move(file), tile, fields);
}

}  // namespace store
}  // namespace tessera

#include <cstddef>
#include <cstring>
#include <utility>

#include "src/base/image.h"
#include "src/front/api/tile_impl.h"

namespace tessera {

const char* numpy_name(AttributeType type) {
  switch (type) {
    case AttributeType::u8:
      return "uint8";
    case AttributeType::i8:
      return "int8";
    case AttributeType::u16:
      return "uint16";
    case AttributeType::i16:
      return "int16";
    case AttributeType::u32:
      return "uint32";
    case AttributeType::i32:
      return "int32";
    case AttributeType::u64:
      return "uint64";
    case AttributeType::i64:
      return "int64";
    case AttributeType::f32:
      return "float32";
    case AttributeType::f64:
      return "float64";
  }
  return "";
}

struct Tile::Impl {
  std::uint32_t id = 0;
  TileMesh mesh;
  std::vector<std::vector<std::byte>> columns;  // the values of each attribute
  std::vector<std::vector<std::byte>> of_cells;
  std::vector<Field> attributes, cell_fields;
  std::vector<std::int8_t> offsets;  // three a vertex

  void set_offsets() {
    for (const std::uint8_t code : mesh.offsets) {
      for (const int periods : image::offset(code).by) offsets.push_back(static_cast<std::int8_t>(periods));
    }
  }

  void set_attributes(const std::vector<Attribute>& schema, const std::vector<std::byte>& rows) {
    const std::size_t stride = row_bytes(schema), n = mesh.points.size();
    std::size_t offset = 0;
    for (const Attribute& attribute : schema) {
      const std::size_t size = size_of(attribute.type);
      auto& column = columns.emplace_back(n * size);
      for (std::size_t i = 0; i < n; ++i) std::memcpy(&column[i * size], &rows[i * stride + offset], size);
      attributes.push_back({attribute.name, numpy_name(attribute.type), column});
      offset += size;
    }
  }
  void set_cell_columns(const std::vector<Attribute>& schema, std::vector<std::vector<std::byte>> values) {
    of_cells = std::move(values);
    for (std::size_t c = 0; c < of_cells.size(); ++c)
      cell_fields.push_back({schema[c].name, numpy_name(schema[c].type), of_cells[c]});
  }
};

std::uint32_t Tile::id() const { return impl_->id; }
int Tile::dimension() const { return impl_->mesh.dimension; }
std::span<const double> Tile::points() const {
  static_assert(sizeof(Point) == 3 * sizeof(double));
  const auto& points = impl_->mesh.points;
  return {reinterpret_cast<const double*>(points.data()), 3 * points.size()};
}
std::span<const std::uint64_t> Tile::ids() const { return numbers_of(impl_->mesh.ids); }
std::span<const std::uint8_t> Tile::foreign() const { return impl_->mesh.point_ghost; }
std::span<const std::int8_t> Tile::offsets() const { return impl_->offsets; }
std::span<const std::int32_t> Tile::cells() const { return impl_->mesh.cells; }
std::span<const std::uint8_t> Tile::ghost() const { return impl_->mesh.cell_ghost; }
std::span<const std::int32_t> Tile::neighbors() const { return impl_->mesh.neighbors; }
const std::vector<Tile::Field>& Tile::attributes() const { return impl_->attributes; }
const std::vector<Tile::Field>& Tile::cell_columns() const { return impl_->cell_fields; }

Tile TileMaker::make(std::uint32_t id, StoredTile stored) {
  auto tile = std::make_shared<Tile::Impl>();
  tile->id = id;
  tile->mesh = std::move(stored.mesh);
  tile->set_offsets();
  tile->set_attributes(stored.schema, stored.rows);
  tile->set_cell_columns(stored.cell_schema, std::move(stored.cell_columns));
  return Tile(std::move(tile));
}

}  // namespace tessera

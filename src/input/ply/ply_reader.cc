#include "src/input/ply/ply_reader.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/column_names.h"
#include "src/input/ply/ply_header.h"
#include "src/input/ply/ply_vertices.h"

namespace tessera {
namespace {

// Which property is which coordinate or attribute.
struct PlyColumns {
  std::array<std::optional<std::size_t>, 3> coordinates;
  struct Extra {
    Attribute attribute;
    std::size_t property;
  };
  std::vector<Extra> extras;
};

PlyColumns columns_of(const PlyElement& vertex) {
  PlyColumns columns;
  AttributeNames names;
  for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
    const auto& property = vertex.properties[i];
    if (property.count || property.name == unnamed_column) continue;
    const std::size_t axis = property.name.size() == 1 ? std::string_view("xyzXYZ").find(property.name) % 3 : 3;
    const bool named = property.name.size() == 1 && std::string_view("xyzXYZ").find(property.name) < 6;
    if (named && !columns.coordinates[axis])
      columns.coordinates[axis] = i;
    else
      columns.extras.push_back({{names.make(property.name), property.type}, i});
  }
  return columns;
}

class PlyReader : public PointReader {
 public:
  PlyReader(FileInfo info, std::unique_ptr<PlyVertices> vertices, const PlyColumns& columns,
            const std::vector<Attribute>& schema)
      : info_(std::move(info)), vertices_(std::move(vertices)), row_bytes_(row_bytes(schema)) {
    const auto offsets = row_offsets(schema);
    for (const auto& scalar : vertices_->scalars()) {
      const auto copy_to = [&](AttributeType type) { return column_copy(scalar.stored, scalar.swapped, type); };
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (columns.coordinates[axis] == scalar.property)
          coordinates_.push_back({scalar.offset, axis * sizeof(double), copy_to(AttributeType::f64)});
      for (const auto& extra : columns.extras)
        for (std::size_t i = 0; i < schema.size(); ++i)
          if (extra.property == scalar.property && extra.attribute.name == schema[i].name)
            cells_.push_back({scalar.offset, offsets[i], copy_to(schema[i].type)});
    }
  }

  const FileInfo& info() const override { return info_; }

  Status next(PointBatch& batch, std::size_t most) override {
    BOOST_OUTCOME_TRY(block, vertices_->next(most));
    const std::size_t stride = vertices_->record_bytes();
    const std::size_t n = block.size() / stride;
    batch.points.assign(n, Point{});
    batch.rows.assign(n * row_bytes_, std::byte{0});
    if (n == 0) return success();
    auto* points = reinterpret_cast<std::byte*>(batch.points.data());
    for (const auto& c : coordinates_) c.copy(block.data() + c.from, stride, points + c.to, sizeof(Point), n);
    for (const auto& c : cells_) c.copy(block.data() + c.from, stride, batch.rows.data() + c.to, row_bytes_, n);
    return success();
  }

  Result<bool> seek(std::uint64_t index) override { return vertices_->seek(index); }
  std::string place(std::size_t index) const override { return vertices_->place(index); }

 private:
  struct Column {
    std::size_t from, to;
    ColumnCopy copy;
  };

  FileInfo info_;
  std::unique_ptr<PlyVertices> vertices_;
  std::size_t row_bytes_;
  std::vector<Column> coordinates_, cells_;
};

}  // namespace

Result<std::unique_ptr<PointReader>> read_vertices(FileInfo info, std::unique_ptr<PlyVertices> vertices,
                                                   const PlyElement& vertex, const std::vector<Attribute>& attributes) {
  const PlyColumns columns = columns_of(vertex);
  if (!columns.coordinates[0] || !columns.coordinates[1])
    return error(Errc::bad_input,
                 info.path.string() + ": the vertices have no property '" + (columns.coordinates[0] ? "y" : "x") + "'");
  const auto type = vertex.properties[*columns.coordinates[0]].type;
  info.detail += type == AttributeType::f32 ? ", float" : type == AttributeType::f64 ? ", double" : ", integers";
  info.dimension = columns.coordinates[2] ? 3 : 2;
  info.points = vertex.count;
  for (const auto& extra : columns.extras) info.attributes.push_back(extra.attribute);
  return std::unique_ptr<PointReader>(new PlyReader(std::move(info), std::move(vertices), columns, attributes));
}

Result<std::unique_ptr<PointReader>> open_ply(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes) {
  BOOST_OUTCOME_TRY(header, read_ply_header(*source));
  FileInfo info = info_of(*source, "ply");
  constexpr std::array<const char*, 3> formats{"ASCII", "binary little endian", "binary big endian"};
  info.detail = formats[static_cast<std::size_t>(header.format)];
  BOOST_OUTCOME_TRY(vertices, open_ply_vertices(std::move(source), header));
  return read_vertices(std::move(info), std::move(vertices), header.elements[header.vertex], attributes);
}

}  // namespace tessera

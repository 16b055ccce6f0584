#include "src/input/pcd/pcd_reader.h"

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/pcd/compressed_vertices.h"
#include "src/input/pcd/pcd_header.h"
#include "src/input/pcd/text_colours.h"
#include "src/input/ply/ply_header.h"
#include "src/input/ply/ply_reader.h"
#include "src/input/ply/ply_vertices.h"

namespace tessera {
namespace {

bool is_packed_colour(const PcdField& field) {
  return (field.name == "rgb" || field.name == "rgba") && field.count == 1 && size_of(field.type) == 4;
}

// The fields as properties of a PLY element. Its records are those of a binary PCD file.
PlyElement element_of(const PcdHeader& header) {
  PlyElement element{.name = "vertex", .count = header.points, .properties = {}};
  const auto add = [&](std::string name, AttributeType type) {
    element.properties.push_back({.name = std::move(name), .type = type, .count = {}});
  };
  for (const auto& field : header.fields) {
    if (is_packed_colour(field) && header.data != PcdData::ascii) {
      for (const char* name : {"blue", "green", "red"}) add(name, AttributeType::u8);
      add(field.name == "rgba" ? "alpha" : "_", AttributeType::u8);
    } else if (field.count == 1 || field.name == "_") {
      for (std::size_t i = 0; i < field.count; ++i) add(field.name, field.type);
    } else {
      for (std::size_t i = 0; i < field.count; ++i) add(field.name + "_" + std::to_string(i + 1), field.type);
    }
  }
  return element;
}

Result<std::unique_ptr<PlyVertices>> open_vertices(std::unique_ptr<ByteSource> source, const PcdHeader& header,
                                                   PlyElement& element, bool coordinates_only) {
  if (header.data == PcdData::binary_compressed)
    return open_compressed_vertices(std::move(source), header, element, coordinates_only);
  const PlyFormat format = header.data == PcdData::ascii ? PlyFormat::ascii : PlyFormat::binary_little_endian;
  BOOST_OUTCOME_TRY(
      vertices,
      open_ply_vertices(
          std::move(source),
          {.format = format, .elements = {element}, .vertex = 0, .body_at = header.body_at, .lines = header.lines}));
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const auto& name = element.properties[i].name;
    if (header.data == PcdData::ascii && (name == "rgb" || name == "rgba"))
      vertices = unpack_text_colours(std::move(vertices), i, element);
  }
  return vertices;
}

}  // namespace

bool looks_like_pcd(std::string_view begin) {
  return begin.starts_with("# .PCD") || begin.starts_with("VERSION 0.7\n") || begin.starts_with("VERSION .7\n") ||
         begin.starts_with("VERSION 0.7\r\n") || begin.starts_with("VERSION .7\r\n");
}

Result<std::unique_ptr<PointReader>> open_pcd(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes) {
  BOOST_OUTCOME_TRY(header, read_pcd_header(*source));
  FileInfo info = info_of(*source, "pcd");
  if (header.points == 0 || header.point_bytes() == 0)
    return error(Errc::bad_input, info.path.string() + ": holds no points");
  constexpr std::array<const char*, 3> kinds{"ASCII", "binary", "binary compressed"};
  info.detail = kinds[static_cast<std::size_t>(header.data)];
  PlyElement element = element_of(header);
  BOOST_OUTCOME_TRY(vertices, open_vertices(std::move(source), header, element, attributes.empty()));
  return read_vertices(std::move(info), std::move(vertices), element, attributes);
}

}  // namespace tessera

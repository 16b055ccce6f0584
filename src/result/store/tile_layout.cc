#include "src/result/store/tile_layout.h"

#include <algorithm>
#include <set>
#include <string_view>

namespace tessera::store {

namespace {

// The bytes of the first character of `text`, if XML 1.0 and JSON can hold it; else 0.
std::size_t storable_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  std::uint32_t code = first & (0xffu >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const std::uint32_t least = length == 2 ? 0x80 : length == 3 ? 0x800 : 0x10000;
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  const bool control = code >= 0x80 && code < 0xa0;
  return code < least || code > 0x10ffff || surrogate || control || (code & 0xfffe) == 0xfffe ? 0 : length;
}

std::string storable_name(std::string_view name) {
  std::string result;
  while (!name.empty()) {
    const std::size_t length = name.front() == '/' ? 0 : storable_character(name);
    result += length == 0 ? "_" : name.substr(0, length);
    name.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result;
}

}  // namespace

std::vector<ArrayInfo> tile_arrays(int dimension, bool final, bool neighbors, const std::vector<Attribute>& schema,
                                   const std::vector<Attribute>& cell_schema, bool images) {
  const auto corners = static_cast<std::uint64_t>(dimension + 1);
  std::vector<ArrayInfo> arrays{
      {Section::points, "Points", AttributeType::f64, ArrayOf::points, 3, Packing::plain},
      {Section::point_data, "id", AttributeType::u64, ArrayOf::points, 1, Packing::plain},
      {Section::point_data, "owner", AttributeType::u32, ArrayOf::points, 1, Packing::deflated},
      {Section::point_data, "vtkGhostType", AttributeType::u8, ArrayOf::points, 1, Packing::deflated},
  };
  for (const auto& attribute : schema)
    arrays.push_back({Section::point_data, attribute.name, attribute.type, ArrayOf::points, 1, Packing::plain});
  if (images)
    arrays.push_back({Section::point_data, images_array, AttributeType::i8, ArrayOf::points, 3, Packing::deflated});
  arrays.push_back({Section::cells, "connectivity", AttributeType::i32, ArrayOf::corners, 1, Packing::plain});
  arrays.push_back({Section::cells, "offsets", AttributeType::i32, ArrayOf::cells, 1, Packing::deflated});
  arrays.push_back({Section::cells, "types", AttributeType::u8, ArrayOf::cells, 1, Packing::deflated});
  arrays.push_back({Section::cell_data, "vtkGhostType", AttributeType::u8, ArrayOf::cells, 1, Packing::deflated});
  arrays.push_back({Section::cell_data, "tile", AttributeType::u32, ArrayOf::cells, 1, Packing::deflated});
  if (final) arrays.push_back({Section::cell_data, "final", AttributeType::u8, ArrayOf::cells, 1, Packing::deflated});
  if (neighbors)
    arrays.push_back({Section::cell_data, "neighbors", AttributeType::i32, ArrayOf::cells, corners, Packing::plain});
  for (const auto& column : cell_schema)
    arrays.push_back({Section::cell_data, column.name, column.type, ArrayOf::cells, 1, Packing::plain});
  return arrays;
}

namespace {

std::size_t place_of(const std::vector<ArrayInfo>& arrays, Section section, std::string_view name) {
  const auto found = std::find_if(arrays.begin(), arrays.end(),
                                  [&](const ArrayInfo& a) { return a.section == section && a.name == name; });
  return static_cast<std::size_t>(found - arrays.begin());
}

}  // namespace

std::size_t connectivity_of(const std::vector<ArrayInfo>& arrays) {
  return place_of(arrays, Section::cells, "connectivity");
}

std::size_t neighbors_of(const std::vector<ArrayInfo>& arrays) {
  return place_of(arrays, Section::cell_data, "neighbors");
}

namespace {

Result<std::vector<Attribute>> stored_names(const std::vector<Attribute>& schema, const std::set<std::string>& taken) {
  std::vector<Attribute> result = schema;
  std::set<std::string> names = taken;
  for (auto& attribute : result) {
    attribute.name = storable_name(attribute.name);
    if (taken.contains(attribute.name)) attribute.name += '_';
    if (attribute.name.empty()) return error(Errc::usage, "an attribute whose name is empty cannot be stored");
    if (!names.insert(attribute.name).second)
      return error(Errc::usage, "two attributes would both be stored as '" + attribute.name + "'");
  }
  return result;
}

}  // namespace

Result<std::vector<Attribute>> stored_schema(const std::vector<Attribute>& schema) {
  return stored_names(schema, {"id", "owner", "vtkGhostType", images_array});
}

Result<std::vector<Attribute>> stored_cell_schema(const std::vector<Attribute>& schema) {
  return stored_names(schema, {"vtkGhostType", "tile", "final", "neighbors"});
}

}  // namespace tessera::store

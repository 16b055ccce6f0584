// The columns of a file of cells.
#pragma once

#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/attribute_value.h"
#include "src/result/export/field_name.h"
#include "src/result/voronoi/cell_records.h"

namespace tessera::voronoi {

inline constexpr const char* first_fields[] = {"id", "area", "neighbours", "unbounded", "centroid_x", "centroid_y"};

// The names of the columns of attributes, which differ from the first fields.
inline std::vector<std::string> attribute_fields(const std::vector<Attribute>& schema) {
  std::set<std::string> taken{"fid", "geom", "ogc_fid"};
  taken.insert(std::begin(first_fields), std::end(first_fields));
  std::vector<std::string> names;
  for (const Attribute& attribute : schema) names.push_back(exports::field_name(attribute.name, taken));
  return names;
}

// The integers of GDAL and SQLite have 64 bits and a sign.
template <class Value>
constexpr bool is_real = std::is_floating_point_v<Value> || std::is_same_v<Value, std::uint64_t>;

inline bool is_real_type(AttributeType type) {
  return type == AttributeType::f32 || type == AttributeType::f64 || type == AttributeType::u64;
}

// Calls visit(column, value) for all columns in their order, with values in their types.
template <class Visit>
void for_each_value(const CellRecord& record, const std::vector<Attribute>& schema, const Visit& visit) {
  visit(0, static_cast<std::int64_t>(record.head.id));
  visit(1, record.head.size);
  visit(2, record.head.neighbours);
  visit(3, record.head.unbounded != 0);
  visit(4, record.head.centroid[0]);
  visit(5, record.head.centroid[1]);
  const std::byte* at = record.row.data();
  int column = 6;
  for (const Attribute& attribute : schema) {
    visit_value(attribute.type, at, [&](auto value) { visit(column, value); });
    at += size_of(attribute.type);
    ++column;
  }
}

}  // namespace tessera::voronoi

#include "src/result/store/manifest_json.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/names.h"
#include "src/base/json/json_text.h"
#include "src/result/store/tile_layout.h"

namespace tessera {

using nlohmann::json;
using nlohmann::ordered_json;

namespace store {

namespace {

constexpr const char* attribute_types[] = {"u8", "i8", "u16", "i16", "u32", "i32", "u64", "i64", "f32", "f64"};

json::other_error wrong(const std::string& what, const json& value) {
  return json::other_error::create(501, what, &value);
}

std::uint32_t to_version(const json& value) {
  const std::uint64_t version = to_count(value);
  if (version < 2 || version > std::numeric_limits<std::uint32_t>::max())
    throw wrong(std::to_string(version) + " is not a valid number of a version after the first", value);
  return static_cast<std::uint32_t>(version);
}

ordered_json column_to_json(const ResultColumn& column) {
  ordered_json value{{"name", column.name},
                     {"of", column.of_cells ? "cells" : "vertices"},
                     {"type", name_of(column.type)},
                     {"unit", column.unit},
                     {"version", column.version},
                     {"command", column.command},
                     {"software_version", column.software_version}};
  if (column.total) value["total"] = number(*column.total);
  return value;
}

ResultColumn to_column(const json& value) {
  ResultColumn column;
  column.name = to_name(value);
  const auto of = value.at("of").get<std::string>();
  if (of != "cells" && of != "vertices") throw wrong("'" + of + "' is neither cells nor vertices", value);
  column.of_cells = of == "cells";
  column.type = to_type(value);
  column.unit = value.at("unit").get<std::string>();
  column.version = to_version(value.at("version"));
  column.command = value.at("command").get<std::vector<std::string>>();
  column.software_version = value.at("software_version").get<std::string>();
  if (value.contains("total")) column.total = to_double(value.at("total"));
  return column;
}

// Checks the columns: those of vertices are the last attributes of the schema, in the same order, and no name comes
// twice.
void check_columns(const Manifest& manifest, const json& value) {
  std::vector<Attribute> of_vertices;
  std::vector<std::string> names;
  for (const ResultColumn& column : manifest.columns) {
    if (column.version > manifest.version) throw wrong("column '" + column.name + "' is of a later version", value);
    if (!column.of_cells) of_vertices.push_back({column.name, column.type});
    names.push_back(column.name);
  }
  std::ranges::sort(names);
  if (std::ranges::adjacent_find(names) != names.end()) throw wrong("two columns have the same name", value);
  const auto& schema = manifest.schema;
  if (of_vertices.size() > schema.size() || !std::equal(of_vertices.rbegin(), of_vertices.rend(), schema.rbegin()))
    throw wrong("the columns of vertices are not the last of its attributes", value);
  const auto cells = cell_schema_of(manifest);
  const auto stored = stored_cell_schema(cells);
  if (!stored || stored.value() != cells) throw wrong("a column of cells has a name that a file cannot have", value);
}

}  // namespace

ordered_json number(double value) {
  if (value == std::numeric_limits<double>::infinity()) return "inf";
  if (value == -std::numeric_limits<double>::infinity()) return "-inf";
  return value;
}

double to_double(const json& value) {
  if (value.is_string()) {
    if (value == "inf") return std::numeric_limits<double>::infinity();
    if (value == "-inf") return -std::numeric_limits<double>::infinity();
    throw wrong("'" + value.get<std::string>() + "' is not a number", value);
  }
  return value.get<double>();
}

std::uint64_t to_count(const json& value) {
  if (!value.is_number_unsigned()) throw wrong(json_text(value) + " is not a count", value);
  return value.get<std::uint64_t>();
}

std::uint64_t to_sum(const json& value) {
  const auto text = value.get<std::string>();
  if (text.size() != 16 || text.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw wrong("'" + text + "' is not a checksum", value);
  return std::stoull(text, nullptr, 16);
}

const char* name_of(AttributeType type) { return attribute_types[static_cast<int>(type)]; }

AttributeType to_type(const json& value) {
  const auto type = value.at("type").get<std::string>();
  const auto found = std::find(std::begin(attribute_types), std::end(attribute_types), type);
  if (found == std::end(attribute_types)) throw wrong("'" + type + "' is not a type", value);
  return static_cast<AttributeType>(found - std::begin(attribute_types));
}

std::string to_name(const json& value) {
  auto name = value.at("name").get<std::string>();
  // Exports name files by it, and tile files cannot have such a name.
  if (name.find_first_of(std::string_view("/\0", 2)) != std::string::npos)
    throw wrong("an attribute's name holds a '/' or a zero byte", value);
  return name;
}

void write_versions(const Manifest& manifest, ordered_json& value) {
  if (manifest.version == 1) return;
  value["version"] = manifest.version;
  value["columns"] = json::array();
  for (const auto& column : manifest.columns) value["columns"].push_back(column_to_json(column));
  if (manifest.previous_master_xxh3) value["previous_master"] = checksum_text(*manifest.previous_master_xxh3);
}

void read_versions(const json& value, Manifest& manifest) {
  if (manifest.format_version < changed_format || !value.contains("version")) return;
  manifest.version = to_version(value.at("version"));
  for (const auto& column : value.at("columns")) manifest.columns.push_back(to_column(column));
  if (value.contains("previous_master")) manifest.previous_master_xxh3 = to_sum(value.at("previous_master"));
  check_columns(manifest, value);
}

}  // namespace store

Manifest without_columns(Manifest manifest) {
  const auto of_vertices =
      std::ranges::count_if(manifest.columns, [](const ResultColumn& column) { return !column.of_cells; });
  manifest.schema.resize(manifest.schema.size() - static_cast<std::size_t>(of_vertices));
  manifest.columns.clear();
  return manifest;
}

std::vector<Attribute> cell_schema_of(const Manifest& manifest) {
  std::vector<Attribute> schema;
  for (const ResultColumn& column : manifest.columns)
    if (column.of_cells) schema.push_back({column.name, column.type});
  return schema;
}

}  // namespace tessera

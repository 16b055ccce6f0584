#include "src/job/describe_columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/job/describe.h"
#include "src/result/tile_source.h"

namespace tessera {

namespace {

using Json = nlohmann::ordered_json;

// The names of NumPy.
const char* type_name(AttributeType type) {
  constexpr std::array names{"uint8", "int8",   "uint16", "int16",   "uint32",
                             "int32", "uint64", "int64",  "float32", "float64"};
  return names[static_cast<std::size_t>(type)];
}

std::string digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

using Row = std::array<std::string, 6>;

std::string table(const std::vector<Row>& rows) {
  std::array<std::size_t, std::tuple_size_v<Row>> widths{};
  for (const Row& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      std::string cell = row[i];
      cell.resize(widths[i], ' ');
      line += "  " + cell;
    }
    line.resize(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

}  // namespace

Json columns_to_json(const Manifest& manifest) {
  Json list = Json::array();
  for (const ResultColumn& column : manifest.columns) {
    Json value{{"name", column.name},
               {"of", column.of_cells ? "cells" : "vertices"},
               {"type", type_name(column.type)},
               {"unit", column.unit},
               {"version", column.version},
               {"software_version", column.software_version},
               {"command", column.command}};
    if (column.total) value["total"] = std::isfinite(*column.total) ? Json(*column.total) : Json();
    list.push_back(std::move(value));
  }
  return list;
}

std::string columns_in_words(const Json& columns) {
  std::string text;
  for (const auto& column : columns)
    text +=
        (text.empty() ? "" : ", ") + column.at("name").get<std::string>() + " of " + column.at("of").get<std::string>();
  return text;
}

Result<std::string> describe_columns(const std::string& folder, bool json) {
  BOOST_OUTCOME_TRY(source, TileSource::open(folder, Periods::known));
  const Manifest& manifest = source.manifest();
  if (json) {
    const Json object{{"result", folder}, {"version", manifest.version}, {"columns", columns_to_json(manifest)}};
    return json_text(object) + "\n";
  }
  std::string text = printable(folder) + ", version " + std::to_string(manifest.version) + "\n";
  if (manifest.columns.empty()) return text + "  no columns: nothing was computed of this result\n";
  std::vector<Row> rows{{"name", "of", "type", "unit", "total", "made by"}};
  for (const ResultColumn& column : manifest.columns) {
    std::string command;
    for (const auto& word : column.command) command += (command.empty() ? "" : " ") + word;
    rows.push_back({printable(column.name), column.of_cells ? "cells" : "vertices", type_name(column.type),
                    printable(column.unit), column.total ? digits(*column.total) : "",
                    printable("Tessera " + column.software_version + (command.empty() ? "" : ": " + command))});
  }
  return text + table(rows);
}

}  // namespace tessera

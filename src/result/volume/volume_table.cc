#include "src/result/volume/volume_table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/export/ending.h"
#include "src/result/export/geopackage.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

struct TableColumn {
  const char* name;
  double VolumeRow::*value;
  bool is_area;
  const char* meaning;
};

constexpr std::array<TableColumn, 9> columns{{
    {"cut", &VolumeRow::cut, false, "where A lies above B: material to take away to come from A to B"},
    {"fill", &VolumeRow::fill, false, "where B lies above A: material to add to come from A to B"},
    {"net", &VolumeRow::net, false, "cut - fill; below 0 when more is added than taken away"},
    {"mean", &VolumeRow::mean, false, "the mean of A - B over the covered area"},
    {"area", &VolumeRow::area, true, "of the polygon; without polygons, of what A or B covers"},
    {"covered", &VolumeRow::covered, true, "of it, by A and B; the volumes are those over it"},
    {"uncovered", &VolumeRow::uncovered, true, "the rest: holes, and what is outside of a hull"},
    {"uncovered_by_a", &VolumeRow::uncovered_by_a, true, "of the area, not covered by A"},
    {"uncovered_by_b", &VolumeRow::uncovered_by_b, true, "of the area, not covered by B"},
}};

std::string digits_of(double value) {
  std::array<char, 40> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

std::string short_text(double value) {
  std::array<char, 40> digits{};
  std::snprintf(digits.data(), digits.size(), "%.10g", value);
  return digits.data();
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == text.npos) return text;
  std::string all = "\"";
  for (const char c : text) all += c == '"' ? std::string("\"\"") : std::string(1, c);
  return all + "\"";
}

// The unit with a space before it.
std::string unit_of(const Volumes& volumes, const TableColumn& column) {
  if (column.value == &VolumeRow::mean) return "";
  const std::string& unit = column.is_area ? volumes.area_unit : volumes.volume_unit;
  return unit.empty() ? "" : " " + unit;
}

void pad(std::string& line, std::size_t width) { line.append(width - std::min(width, line.size()), ' '); }

// One row: a line a value, with what it means.
std::string text_of_one(const Volumes& volumes) {
  std::string text;
  for (const TableColumn& column : columns) {
    std::string line = column.name;
    pad(line, 16);
    const double value = volumes.rows[0].*column.value;
    line += std::isnan(value) ? std::string("-") : short_text(value) + unit_of(volumes, column);
    pad(line, 44);
    text += line + " " + column.meaning + "\n";
  }
  return text;
}

nlohmann::ordered_json json_of(const Volumes& volumes, const VolumeRow& row) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  if (volumes.polygons) {
    object["polygon"] = row.feature.value_or(0);
    object["name"] = row.name;
  }
  for (const TableColumn& column : columns) {
    const double value = row.*column.value;
    object[column.name] = std::isnan(value) ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
  }
  return object;
}

nlohmann::ordered_json json_of(const Volumes& volumes) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const VolumeRow& row : volumes.rows) rows.push_back(json_of(volumes, row));
  return {{"rows", std::move(rows)},
          {"area_unit", volumes.area_unit},
          {"volume_unit", volumes.volume_unit},
          {"long_edges", volumes.long_edges},
          {"without_height", volumes.without_height},
          {"note", volumes.note}};
}

Status write_geopackage(const Volumes& volumes, const fs::path& target) {
  BOOST_OUTCOME_TRY(file, exports::GeoPackage::create(target, crs_or_none(volumes.crs), {}));
  std::vector<exports::GeoPackage::Field> fields{{"polygon", OFTInteger64}, {"name", OFTString}};
  for (const TableColumn& column : columns) fields.push_back({column.name, OFTReal});
  BOOST_OUTCOME_TRY(layer, file->add_layer("volumes", wkbUnknown, fields, true));
  BOOST_OUTCOME_TRYV(file->begin());
  const GdalLibrary& gdal = file->gdal();
  for (const VolumeRow& row : volumes.rows) {
    gdal.OGR_F_SetFieldInteger64(layer.feature, 0, row.feature.value_or(0));
    gdal.OGR_F_SetFieldString(layer.feature, 1, row.name.c_str());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double value = row.*columns[c].value;
      const int field = static_cast<int>(c) + 2;
      if (std::isnan(value))
        gdal.OGR_F_SetFieldNull(layer.feature, field);
      else
        gdal.OGR_F_SetFieldDouble(layer.feature, field, value);
    }
    BOOST_OUTCOME_TRYV(file->add(layer, row.wkb.data(), row.wkb.size()));
  }
  BOOST_OUTCOME_TRYV(file->finish());
  return success();
}

}  // namespace

std::string to_text(const Volumes& volumes) {
  if (!volumes.polygons) return text_of_one(volumes);
  std::string text;
  for (const TableColumn& column : columns)
    text += std::string(column.name) + ": " + column.meaning +
            (unit_of(volumes, column).empty() ? "" : "," + unit_of(volumes, column)) + "\n";
  std::vector<std::vector<std::string>> cells{{"polygon", "name"}};
  for (const TableColumn& column : columns) cells[0].emplace_back(column.name);
  for (const VolumeRow& row : volumes.rows) {
    std::vector<std::string> line{std::to_string(row.feature.value_or(0)), row.name};
    for (const TableColumn& column : columns) {
      const double value = row.*column.value;
      line.push_back(std::isnan(value) ? "-" : short_text(value));
    }
    cells.push_back(std::move(line));
  }
  std::vector<std::size_t> widths(cells[0].size());
  for (const auto& line : cells)
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  for (const auto& line : cells) {
    std::string all;
    for (std::size_t c = 0; c < line.size(); ++c) {
      std::string cell = line[c];
      if (c + 1 < line.size()) pad(cell, widths[c] + 2);
      all += cell;
    }
    text += all + "\n";
  }
  return text;
}

std::string to_csv(const Volumes& volumes) {
  std::string text = volumes.polygons ? "polygon,name" : "";
  for (const TableColumn& column : columns) text += (text.empty() ? "" : ",") + std::string(column.name);
  text += "\n";
  for (const VolumeRow& row : volumes.rows) {
    std::string line = volumes.polygons ? std::to_string(row.feature.value_or(0)) + "," + quoted(row.name) : "";
    for (const TableColumn& column : columns) {
      const double value = row.*column.value;
      line += (&column == &columns.front() && line.empty() ? "" : ",") + (std::isnan(value) ? "" : digits_of(value));
    }
    text += line + "\n";
  }
  return text;
}

std::string to_json(const Volumes& volumes, const fs::path& output) {
  nlohmann::ordered_json object{{"event", "volumes"}};
  if (!output.empty()) object["output"] = output.string();
  object.update(json_of(volumes));
  return json_text(object);
}

Status check_volumes_target(const fs::path& target, bool polygons, bool overwrite) {
  const std::string ending = exports::ending_of(target);
  if (ending != ".csv" && ending != ".json" && ending != ".gpkg")
    return error(Errc::usage,
                 target.string() + ": is not a name of a table; give one that ends in .csv, .json or .gpkg");
  if (ending == ".gpkg" && !polygons)
    return error(Errc::usage, target.string() + ": a GeoPackage holds polygons, and there are none without " +
                                  option("within") + " or " + option("base") + "; write .csv or .json");
  return exports::check_free(target, overwrite);
}

Status write_volumes(const Volumes& volumes, const fs::path& target) {
  const std::string ending = exports::ending_of(target);
  if (ending == ".gpkg") return write_geopackage(volumes, target);
  if (ending == ".csv") return write_whole(target, to_csv(volumes));
  return write_whole(target, json_text(json_of(volumes), 2) + "\n");
}

}  // namespace tessera

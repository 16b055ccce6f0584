#include "src/job/description.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <exception>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "src/base/json/json_text.h"
#include "src/base/phases.h"
#include "src/base/printable.h"
#include "src/input/cloud/cloud.h"
#include "src/job/describe.h"
#include "src/job/describe_columns.h"
#include "src/job/report/human.h"
#include "src/job/report/summary.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

// Says how many tiles are kept as points.
std::string kept_text(std::uint64_t of_points, std::size_t tiles) {
  if (of_points == 0) return "";
  return of_points == tiles ? ", kept as points" : ", " + grouped(of_points) + " of them kept as points";
}

// Source: ASPRS, LAS Specification 1.4 - R15, table 17.
const char* class_name(int number) {
  constexpr std::array names{"never classified",
                             "unassigned",
                             "ground",
                             "low vegetation",
                             "medium vegetation",
                             "high vegetation",
                             "building",
                             "low point",
                             "model key point",
                             "water",
                             "rail",
                             "road",
                             "overlap",
                             "wire guard",
                             "wire conductor",
                             "transmission tower",
                             "wire connector",
                             "bridge deck",
                             "high noise",
                             "overhead structure",
                             "ignored ground",
                             "snow",
                             "temporal exclusion"};
  return number >= 0 && number < static_cast<int>(names.size()) ? names[static_cast<std::size_t>(number)]
         : number < 64                                          ? "reserved"
                                                                : "of the user";
}

std::string label(const std::string& name) {
  if (name == "classification") return "classes";
  if (name == "return_number") return "returns";
  return name == "number_of_returns" ? "of returns" : name;
}

std::string text_of(const Json& object, const char* key) { return object.at(key).get<std::string>(); }
std::uint64_t count_of(const Json& object, const char* key) { return object.at(key).get<std::uint64_t>(); }

// Names and values in two columns.
class Lines {
 public:
  explicit Lines(std::size_t width) : width_(width) {}
  void add(const std::string& name, const std::string& value) {
    std::string shown = printable(name);
    shown.resize(width_, ' ');
    text_ += "  " + shown + printable(value) + "\n";
  }
  const std::string& text() const { return text_; }

 private:
  std::size_t width_;
  std::string text_;
};

std::string box_text(const Json& bounds, std::size_t dimension) {
  std::string text;
  for (std::size_t axis = 0; axis < dimension; ++axis) {
    text += (text.empty() ? "" : "   ") + coordinate(bounds.at("min").at(axis).get<double>()) + " .. " +
            coordinate(bounds.at("max").at(axis).get<double>());
  }
  return text;
}

std::string box_text_or(const Json& bounds, const char* otherwise) {
  return bounds.is_null() ? otherwise : box_text(bounds, 3);
}

// Returns the box of a region.
std::string region_text(const Json& region, std::size_t dimension) {
  std::string text;
  for (std::size_t axis = 0; axis < dimension; ++axis) {
    const auto end = [&](const char* name) {
      const auto& value = region.at(name).at(axis);
      return value.is_null() ? "any" : coordinate(value.get<double>());
    };
    text += (text.empty() ? "" : "   ") + end("min") + " .. " + end("max");
  }
  return text + (region.at("complete").get<bool>() ? ", all cells that meet it" : ", not all cells that meet it");
}

std::string joined(const Json& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name.get<std::string>();
  return text.empty() ? "none" : text;
}

// Returns "131,072 gas (type 0), 3 stars (type 4) of mass 0.25 each".
std::string particles_text(const Json& kinds) {
  std::string text;
  for (const auto& kind : kinds) {
    text += (text.empty() ? "" : ", ") + grouped(count_of(kind, "count")) + " " + printable(text_of(kind, "name")) +
            " (type " + std::to_string(count_of(kind, "type")) + ")";
    if (!kind.at("mass").is_null()) text += " of mass " + coordinate(kind.at("mass").get<double>()) + " each";
  }
  return text;
}

// Returns "redshift 0.5, hubble 0.7".
std::string numbers_text(const Json& numbers) {
  std::string text;
  for (const auto& [name, value] : numbers.items())
    text += (text.empty() ? "" : ", ") + printable(name) + " " + coordinate(value.get<double>());
  return text;
}

// Returns "coordinates [Mpc], mass [g]".
std::string units_text(const Json& units) {
  std::string text;
  for (const auto& [name, unit] : units.items())
    text += (text.empty() ? "" : ", ") + printable(name) + " [" + printable(unit.get<std::string>()) + "]";
  return text;
}

// Returns "x is column 3, y 2, z 4, by the header".
std::string columns_text(const Json& columns) {
  std::string text;
  for (const auto& [name, number] : columns.items()) {
    if (name != "by")
      text += (text.empty() ? name + " is column " : ", " + name + " ") + std::to_string(number.get<std::uint64_t>());
  }
  const auto by = text_of(columns, "by");
  return text + (by == "header"   ? ", by the header"
                 : by == "option" ? ", as asked for"
                                  : ", by their places, as no header names them");
}

std::string file_text(const Json& file) {
  const std::string path = printable(text_of(file, "path")) + "\n";
  Lines lines(12);
  if (file.contains("error")) {
    lines.add("error", text_of(file, "error"));
    return path + lines.text();
  }
  const auto packing = text_of(file, "packing");
  lines.add("format", text_of(file, "detail") + " (" + (packing.empty() ? "" : packing + ", ") +
                          human_bytes(count_of(file, "bytes")) + ")");
  lines.add("points", file.at("points").is_null() ? "not told by the file" : grouped(count_of(file, "points")));
  lines.add("box", box_text_or(file.at("bounds"), "not told by the file"));
  if (file.contains("columns") && !file.at("columns").is_null()) lines.add("columns", columns_text(file.at("columns")));
  if (file.contains("snapshot")) {
    const Json& snapshot = file.at("snapshot");
    const auto files = count_of(snapshot, "files");
    std::string box;
    for (const auto& size : snapshot.at("box")) box += (box.empty() ? "" : " x ") + coordinate(size.get<double>());
    const bool has_box = snapshot.at("box") != Json::array({0.0, 0.0, 0.0});
    lines.add("snapshot", grouped(count_of(snapshot, "points")) + " particles in " + grouped(files) +
                              (files == 1 ? " file" : " files") + (has_box ? ", a box of " + box : ""));
  }
  if (file.contains("particles")) lines.add("particles", particles_text(file.at("particles")));
  if (file.contains("stated")) lines.add("states", numbers_text(file.at("stated")));
  lines.add("attributes", joined(file.at("attributes")));
  if (file.contains("units")) lines.add("units", units_text(file.at("units")));
  if (!text_of(file, "crs").empty()) lines.add("CRS", text_of(file, "crs_name"));
  if (file.contains("result") && !file.at("result").is_null()) {
    const Json& result = file.at("result");
    lines.add("made of", "version " + std::to_string(count_of(result, "version")) + " of a result" +
                             (result.contains("digest") ? ", digest " + text_of(result, "digest") : ""));
  }
  if (!text_of(file, "crs_note").empty()) lines.add("note", text_of(file, "crs_note"));
  return path + lines.text();
}

std::string histogram_text(const std::string& name, const Json& histogram) {
  std::string text;
  for (const auto& [value, count] : histogram.items()) {
    text += (text.empty() ? "" : ", ") + value;
    if (name == "classification") text += std::string(" ") + class_name(std::stoi(value));
    text += ": " + grouped(count.get<std::uint64_t>());
  }
  return text;
}

std::string statistics_text(const Json& counted) {
  Lines lines(12);
  lines.add("read", grouped(count_of(counted, "points")) + " points, " + grouped(count_of(counted, "invalid")) +
                        " invalid, " + grouped(count_of(counted, "filtered")) + " filtered out");
  if (counted.contains("bounds")) lines.add("box", box_text(counted.at("bounds"), 3));
  if (counted.contains("density")) {
    const auto density = counted.at("density").get<double>();
    lines.add("density", coordinate(std::round(density * 1000) / 1000) + " points a square unit where there are any, " +
                             fixed(std::sqrt(1 / density), 3) + " apart");
  }
  for (const auto& [name, histogram] : counted.items()) {
    if (!histogram.is_object() || name == "bounds") continue;
    const bool flag = std::find(point_flags.begin(), point_flags.end(), name) != point_flags.end();
    const bool none = flag && histogram.size() == 1 && histogram.contains("0");
    if (!none) lines.add(label(name), histogram_text(name, histogram));
  }
  return "All points\n" + lines.text();
}

std::string inputs_text(const Json& described) {
  std::string text;
  for (const auto& file : described.at("files")) text += file_text(file);
  if (!described.contains("estimate")) return text;  // these files cannot be triangulated together
  if (!described.at("statistics").is_null()) text += statistics_text(described.at("statistics"));
  const auto threads = count_of(described, "threads");
  text += "Triangulated in " + std::to_string(count_of(described, "dimension")) + "D on " + std::to_string(threads) +
          (threads == 1 ? " thread" : " threads") + " with " + human_bytes(count_of(described, "memory_budget_bytes")) +
          " of memory, this would be about\n";
  const auto& cost = described.at("estimate");
  std::string phases;
  for (const auto& [name, bytes] : cost.at("phases").items())
    phases += (phases.empty() ? "" : ", ") + plain_phase(name) + " " + human_bytes(bytes.get<std::uint64_t>());
  Lines lines(12);
  lines.add("points", grouped(count_of(described, "points")));
  lines.add("box", box_text_or(described.at("sampled_bounds"), "unknown") +
                       (described.at("sampled").get<bool>() ? " (of a sample)" : " (as the headers say)"));
  lines.add("tiles", std::to_string(count_of(described, "tiles")) + " (" + text_of(described, "partition") +
                         ", at most " + grouped(count_of(described, "max_points_per_tile")) + " points each)");
  lines.add("cells", human_count(count_of(cost, "cells")));
  lines.add("memory", human_bytes(count_of(cost, "memory_bytes")) + " (" + phases +
                          (cost.at("tiles_whole").get<bool>() ? "; tiles stay whole" : "; tiles sleep on disk") + ")");
  lines.add("disk", human_bytes(count_of(cost, "result_bytes")) + " result, " +
                        human_bytes(count_of(cost, "temporary_bytes")) + " while it works");
  lines.add("time", human_seconds(cost.at("seconds").get<double>()));
  text += lines.text();
  for (const auto& warning : described.at("warnings")) text += "warning: " + warning.get<std::string>() + "\n";
  return text;
}

// The name of a figure ends with its unit.
std::string figure(const std::string& name, double value) {
  if (name.ends_with("_s")) return human_seconds(value);
  const bool count = value >= 0 && value < 1e18;
  if (count && name.ends_with("_bytes")) return human_bytes(static_cast<std::uint64_t>(value));
  return count && value == std::floor(value) ? grouped(static_cast<std::uint64_t>(value)) : coordinate(value);
}

// Returns a number below 1 with three significant digits, in every locale.
std::string small_number(double value) {
  char text[32];
  const auto end = std::to_chars(std::begin(text), std::end(text), value, std::chars_format::general, 3);
  return {text, end.ptr};
}

std::string density_text(const Json& result) {
  const auto& low = result.at("bounds").at("min");
  const auto& high = result.at("bounds").at("max");
  const double area =
      (high.at(0).get<double>() - low.at(0).get<double>()) * (high.at(1).get<double>() - low.at(1).get<double>());
  const double density = static_cast<double>(count_of(result, "vertices")) / area;
  if (!std::isfinite(density)) return "";
  return (density < 1 ? small_number(density) : fixed(density, density < 100 ? 1 : 0)) +
         " vertices a square unit of the box";
}

// Adds times and memory of the job, in the words of the summary.
void add_work(Lines& lines, const Json& result) {
  std::string phases;
  double all = 0;
  const Json& seconds = result.at("seconds");
  for (const PhaseRow& row : phase_table) {
    if (!seconds.contains(row.name)) continue;
    const auto took_s = seconds.at(row.name).get<double>();
    all += took_s;
    phases += std::string(phases.empty() ? "" : ", ") + row.label + " " + human_seconds(took_s);
  }
  if (!phases.empty()) lines.add("time", human_seconds(all) + " (" + phases + ")");
  const auto& figures = result.at("figures");
  if (figures.contains("peak_memory_bytes"))
    lines.add("memory", figure("peak_memory_bytes", figures.at("peak_memory_bytes").get<double>()) + " at most");
}

std::string periods_in_words(const Json& period, std::size_t dimension) {
  std::string text;
  for (std::size_t axis = 0; axis < dimension; ++axis) {
    const auto length = period.at(axis).get<double>();
    text +=
        (text.empty() ? "" : ", ") + std::string(1, "xyz"[axis]) + (length > 0 ? " " + coordinate(length) : " none");
  }
  return text;
}

// A daemon of an older release does not tell the number of other heights.
std::string duplicates_text_of(const Json& result) {
  const auto others = result.find("duplicates_at_other_heights");
  const auto keep = kept_point_of(result.value("keep", std::string(name_of(DuplicatePolicy::first))));
  return duplicates_text(others == result.end() || others->is_null() ? 0 : others->get<std::uint64_t>(),
                         keep.value_or(DuplicatePolicy::first));
}

std::string result_text(const Json& result, bool counters) {
  const auto& tiles = result.at("tiles");
  std::uint64_t bytes = 0, least = ~std::uint64_t{0}, most = 0;
  for (const auto& tile : tiles) {
    bytes += count_of(tile, "bytes");
    least = std::min(least, count_of(tile, "points"));
    most = std::max(most, count_of(tile, "points"));
  }
  const auto dimension = result.at("dimension").get<std::size_t>();
  const auto& inputs = result.at("inputs");
  Lines lines(20);
  lines.add("made by", "Tessera " + text_of(result, "software_version") + " from " + grouped(inputs.size()) +
                           (inputs.size() == 1 ? " file" : " files"));
  // A region has not read what it did not need, so invalid and filtered points are not counted.
  const auto region = result.find("region");
  const bool part = region != result.end() && !region->is_null();
  lines.add("points", grouped(count_of(result, "points")) +
                          (part ? " in the files, of which the region takes what it needs"
                                : ", " + grouped(count_of(result, "duplicates")) + duplicates_text_of(result) + ", " +
                                      grouped(count_of(result, "invalid")) + " invalid, " +
                                      grouped(count_of(result, "filtered")) + " filtered out"));
  lines.add("vertices", grouped(count_of(result, "vertices")));
  lines.add(dimension == 3 ? "tetrahedra" : "triangles", grouped(count_of(result, "cells")));
  lines.add("box", box_text(result.at("bounds"), dimension));
  if (const auto period = result.find("period"); period != result.end() && !period->is_null())
    lines.add("period", periods_in_words(*period, result.at("dimension").get<std::size_t>()));
  if (const auto heights = result.find("heights"); heights != result.end() && !heights->is_null())
    lines.add("heights", "z from " + coordinate(heights->at("min").get<double>()) + " to " +
                             coordinate(heights->at("max").get<double>()));
  if (const std::string density = density_text(result); !density.empty()) lines.add("density", density);
  if (part) lines.add("a region", region_text(*region, dimension));
  lines.add("tiles", grouped(tiles.size()) + " (" + text_of(result, "partition") + ")" +
                         (tiles.empty() ? "" : ", " + grouped(least) + " to " + grouped(most) + " vertices each") +
                         kept_text(result.value("tiles_of_points", std::uint64_t{0}), tiles.size()));
  lines.add("size", human_bytes(bytes) + (result.at("neighbors").get<bool>() ? "" : ", without neighbours"));
  if (!result.at("digest").is_null()) lines.add("digest", text_of(result, "digest"));
  lines.add("attributes", joined(result.at("attributes")));
  if (result.contains("units")) lines.add("units", units_text(result.at("units")));
  // An older daemon does not send columns.
  if (const auto columns = result.find("columns"); columns != result.end() && !columns->empty())
    lines.add("columns", columns_in_words(*columns) + " (version " + grouped(count_of(result, "version")) + ")");
  if (!text_of(result, "crs").empty()) lines.add("CRS", text_of(result, "crs_name"));
  add_work(lines, result);
  if (counters) {
    for (const auto& [name, value] : result.at("figures").items()) lines.add(name, figure(name, value.get<double>()));
  }
  return printable(text_of(result, "result")) + "\n" + lines.text();
}

}  // namespace

std::optional<std::string> description_text(const Json& described, bool counters) {
  try {
    return described.contains("result") ? result_text(described, counters) : inputs_text(described);
  } catch (const std::exception&) {  // of JSON, or for a class that is no number
    return std::nullopt;
  }
}

std::string written(const Json& described, bool json, bool counters) {
  if (!json) return description_text(described, counters).value();
  return json_text(described) + "\n";
}

}  // namespace tessera

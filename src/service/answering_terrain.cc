// Answers that are drawn from a surface.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/job/arguments.h"
#include "src/job/report/human.h"
#include "src/result/query/answers.h"
#include "src/result/query/geojson.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/dem.h"
#include "src/result/terrain/grid.h"
#include "src/result/terrain/profile.h"
#include "src/service/answer_messages.h"
#include "src/service/answering.h"
#include "src/service/beneath.h"
#include "src/service/json.h"

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

// The profile by parts, with the value as the third coordinate.
std::string geojson_of(const std::vector<ProfilePoint>& points) {
  Json parts = Json::array();
  for (const auto& p : points) {
    if (parts.size() <= p.part) parts.push_back(Json::array());
    parts.back().push_back({p.x, p.y, p.value});
  }
  // A line has at least two points: a part that only touches the surface is left out.
  std::erase_if(parts.get_ref<Json::array_t&>(), [](const Json& part) { return part.size() < 2; });
  return json_text(Json{{"type", "Feature"},
                        {"properties", Json::object()},
                        {"geometry", {{"type", "MultiLineString"}, {"coordinates", std::move(parts)}}}}) +
         "\n";
}

std::string json_of(const std::vector<ProfilePoint>& points, const std::string& value) {
  Json list = Json::array();
  for (const auto& p : points)
    list.push_back({{"distance", p.distance}, {"x", p.x}, {"y", p.y}, {value, p.value}, {"part", p.part}});
  return json_text(Json{{"points", std::move(list)}}) + "\n";
}

}  // namespace

template <class Options>
Status Answering::read_surface(Options& options) const {
  BOOST_OUTCOME_TRY(longest, longest_edge());
  options.max_edge = longest;
  options.value = word("value", "z");
  if constexpr (requires { options.box; }) {
    if (!question_.options.contains("bbox")) return success();
    BOOST_OUTCOME_TRY(box, read("bbox", [](const std::string& text) { return parse_crop(text, 2); }));
    options.box = Bounds{box.lo, box.hi};
  }
  return success();
}

Result<QuestionAnswer> Answering::dem() const {
  DemOptions options{.memory_bytes = memory_bytes(), .threads = ask_.threads};
  BOOST_OUTCOME_TRY(res, read("res", [](const std::string& text) { return parse_distance(text); }));
  options.res = res;
  BOOST_OUTCOME_TRYV(read_surface(options));
  const std::string type = word("type", "float32");
  if (type != "float32" && type != "float64")
    return error(Errc::usage, "type: '" + type + "' is not a type of pixels; the types are float32 and float64");
  options.doubles = type == "float64";
  const Bounds& bounds = reader_.stored.manifest().bounds;
  BOOST_OUTCOME_TRY(grid, terrain::grid_over(options.res, options.box.value_or(bounds), bounds));
  const auto pixels = static_cast<std::uint64_t>(grid.width) * static_cast<std::uint64_t>(grid.height);
  if (pixels > limits_.pixels)
    return error(Errc::memory, "the raster has " + grouped(static_cast<std::uint64_t>(grid.width)) + " x " +
                                   grouped(static_cast<std::uint64_t>(grid.height)) + " pixels, and an answer " +
                                   grouped(limits_.pixels) + " at most: ask for a smaller bbox or a larger res");
  // The box of the pixels' centres: cells that contain no centre have no pixels. The cells of a small box come from few
  // tiles. When there are too many for memory, all tiles are read one after the other.
  const query::Area area{
      .box = {{grid.centre(grid.column0), grid.centre(grid.row0), 0},
              {grid.centre(grid.column0 + grid.width - 1), grid.centre(grid.row0 + grid.height - 1), 0}},
      .polygon = std::nullopt};
  const auto folder = path_of(reader_.held.folder);
  const auto target = answer_file(folder_, ".tif");
  const Manifest& manifest = reader_.stored.manifest();
  auto cells = manifest.dimension == 2 ? reader_.stored.cells(area, {.bytes_max = memory_bytes()}, ask_)
                                       : Result<query::CellSet>(query::CellSet{});
  if (!cells && cells.error().code != Errc::memory) return cells.error();
  BOOST_OUTCOME_TRY(drawn, cells ? write_dem_of(folder, manifest, cells.value().mesh, target, options, ask_.stop)
                                 : write_dem(folder, target, options, ask_.stop));
  return file(drawn.path, reader_.stored.knows(area.box));
}

Result<QuestionAnswer> Answering::contours() const {
  ContourOptions options{.memory_bytes = memory_bytes(), .threads = ask_.threads};
  BOOST_OUTCOME_TRY(interval, read("interval", [](const std::string& text) { return parse_distance(text); }));
  options.interval = interval;
  if (question_.options.contains("base")) {
    BOOST_OUTCOME_TRY(base, read("base", [](const std::string& text) { return parse_finite(text); }));
    options.base = base;
  }
  for (const auto& [key, to] : {std::pair("smooth", &options.smooth), std::pair("min-length", &options.min_length)}) {
    if (!question_.options.contains(key)) continue;
    BOOST_OUTCOME_TRY(length, read(key, [](const std::string& text) { return parse_distance(text); }));
    *to = length;
  }
  if (question_.options.contains("index-every")) {
    BOOST_OUTCOME_TRY(
        every, read("index-every", [](const std::string& text) { return parse_integer(text, 1, index_every_max); }));
    options.index_every = every;
  }
  BOOST_OUTCOME_TRYV(read_surface(options));
  options.vertices_max = limits_.line_vertices;
  options.samples_max = limits_.pixels;
  const std::string format = word("f", "geojson");
  if (format != "geojson" && format != "gpkg")
    return error(Errc::usage, "f: '" + format + "' is no format of lines; there are geojson and gpkg");
  BOOST_OUTCOME_TRY(
      made, write_contours(path_of(reader_.held.folder), answer_file(folder_, "." + format), options, ask_.stop));
  return file(made.path, reader_.stored.knows(source_box(options).value_or(reader_.stored.manifest().bounds)));
}

Result<QuestionAnswer> Answering::profile() const {
  std::vector<Point> line;
  if (question_.body) {
    if (nested_too_deep(*question_.body)) return error(Errc::usage, "the body: lists are nested too deep for GeoJSON");
    BOOST_OUTCOME_TRY(lines, query::of_geojson(*question_.body, "the body", query::GeoJson::lines));
    if (lines.lists.size() > 1)
      return error(Errc::bad_input, "the body: has " + std::to_string(lines.lists.size()) + " lines, not one");
    BOOST_OUTCOME_TRYV(lines.place.check_in(reader_.stored.manifest().crs, reader_.stored.manifest().bounds));
    line = std::move(lines.lists[0]);
  } else {
    BOOST_OUTCOME_TRY(points, read("line", parse_line));
    line = std::move(points);
  }
  ProfileOptions options{.memory_bytes = memory_bytes(), .stop = ask_.stop};
  BOOST_OUTCOME_TRYV(read_surface(options));
  if (question_.options.contains("digits")) {
    BOOST_OUTCOME_TRY(digits, read("digits", parse_digits));
    options.digits = digits;
  }
  const std::string format = word("f", "csv");
  if (format != "csv" && format != "json" && format != "geojson")
    return error(Errc::usage, "f: '" + format + "' is no format of profiles; there are csv, json and geojson");
  BOOST_OUTCOME_TRY(points, tessera::profile(reader_.stored, path_of(reader_.held.folder), line, options));
  Bounds box;
  for (const Point& p : line) box.add(p);
  if (question_.as_message) return in_bytes(message_of(points).SerializeAsString(), reader_.stored.knows(box));
  QuestionAnswer answer{.type = "text/csv", .final = reader_.stored.knows(box)};
  if (format == "csv") answer.text = to_csv(points, options);
  if (format == "json") answer.text = json_of(points, options.value);
  if (format == "geojson") answer.text = geojson_of(points);
  if (format != "csv") answer.type = format == "json" ? "application/json" : "application/geo+json";
  return answer;
}

}  // namespace tessera

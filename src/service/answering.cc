#include "src/service/answering.h"

#include <fcntl.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/option.h"
#include "src/files/names.h"
#include "src/files/whole_file.h"
#include "src/io/cloud/cloud.h"
#include "src/job/arguments.h"
#include "src/query/answer_text.h"
#include "src/report/human.h"
#include "src/service/beneath.h"
#include "src/service/json.h"
#include "src/terrain/dem.h"
#include "src/terrain/grid.h"

namespace tessera {
namespace {

constexpr const char* json_type = "application/json";

Result<query::Method> parse_method(const std::string& text) {
  if (text.empty() || text == "linear") return query::Method::linear;
  if (text == "natural") return query::Method::natural;
  return error(Errc::usage, "'" + text + "' is no way to interpolate; there are linear and natural");
}

std::string type_of(AnswerFormat format) {
  return format == AnswerFormat::json ? json_type : format == AnswerFormat::csv ? "text/csv" : "application/x-npy";
}

}  // namespace

Answering::Answering(const Reader& reader, const Question& question, const QuestionLimits& limits,
                     std::filesystem::path folder, std::stop_token stop)
    : reader_(reader),
      question_(question),
      limits_(limits),
      folder_(std::move(folder)),
      ask_{.threads = limits.threads, .stop = std::move(stop)},
      dimension_(reader.stored.manifest().dimension) {}

Result<QuestionAnswer> Answering::answer() const {
  switch (question_.about) {
    case Question::About::locate:
      return question_.body ? locate_many() : locate();
    case Question::About::star:
      return star();
    case Question::About::cells:
      return cells();
    case Question::About::interpolate:
      return interpolate();
    case Question::About::dem:
      return dem();
    case Question::About::hull:
      return hull();
    case Question::About::section:
      return section();
    case Question::About::solids:
      return solids();
  }
  return error(Errc::internal, "a question of no kind");
}

std::string Answering::word(const std::string& key, const std::string& usual) const {
  const auto found = question_.options.find(key);
  return found == question_.options.end() ? usual : found->second;
}

Result<QuestionAnswer> Answering::locate() const {
  if (question_.options.contains("cell")) return locate_named();
  const auto at = [&](const std::string& text) { return parse_point(text, dimension_); };
  BOOST_OUTCOME_TRY(p, read("point", at));
  BOOST_OUTCOME_TRY(cells, reader_.stored.locate({&p, 1}, ask_));
  std::optional<query::CellDetails> details;
  if (cells[0]) {
    BOOST_OUTCOME_TRY(found, reader_.stored.details(cells[0]));
    details = std::move(found);
  }
  return QuestionAnswer{.text = json_of(p, dimension_, details), .type = json_type};
}

Result<QuestionAnswer> Answering::locate_many() const {
  BOOST_OUTCOME_TRY(options, many());
  BOOST_OUTCOME_TRY(answers, TextAnswers::make(options));
  BOOST_OUTCOME_TRY(points, points());
  BOOST_OUTCOME_TRY(cells, reader_.stored.locate(points, ask_));
  BOOST_OUTCOME_TRYV(answers->add_cells(points, cells));
  return finished(*answers, options.format);
}

Result<QuestionAnswer> Answering::star() const {
  const auto id = parse_integer(question_.vertex, 0, std::numeric_limits<std::int64_t>::max());
  if (!id) return error(Errc::usage, "a vertex is told by its source index: " + id.error().where);
  std::optional<TileId> owner;
  if (question_.options.contains("tile")) {
    BOOST_OUTCOME_TRY(tile, read("tile", [](const std::string& text) { return parse_integer(text, 0, 999'999); }));
    owner = TileId{static_cast<std::uint32_t>(tile)};
  }
  const PointId asked{static_cast<std::uint64_t>(id.value())};
  BOOST_OUTCOME_TRY(star, reader_.stored.star(asked, owner, ask_));
  return QuestionAnswer{.text = json_of(asked, dimension_, star), .type = json_type};
}

Result<query::Area> Answering::area() const {
  query::Area area;
  if (question_.body) {
    if (nested_too_deep(*question_.body)) return error(Errc::usage, "the body: lists are nested too deep for GeoJSON");
    BOOST_OUTCOME_TRY(polygon, query::Polygon::of_geojson(*question_.body, "the body"));
    constexpr double inf = std::numeric_limits<double>::infinity();
    area.box = polygon.bounds();
    area.box.lo.z = -inf;
    area.box.hi.z = inf;
    area.polygon = std::move(polygon);
    return area;
  }
  if (!question_.options.contains("bbox"))
    return error(Errc::usage, "give the box as bbox=xmin,ymin,xmax,ymax, or send a polygon");
  BOOST_OUTCOME_TRY(box, read("bbox", [&](const std::string& text) { return parse_crop(text, dimension_); }));
  area.box = {box.lo, box.hi};
  return area;
}

Result<QuestionAnswer> Answering::cells() const {
  BOOST_OUTCOME_TRY(area, area());
  BOOST_OUTCOME_TRY(most, limits_of_cells());
  // What it is called does not show; a format without its ending would be a folder.
  const std::string format = word("f", dimension_ == 2 ? "geojson" : "ply");
  if (format == "npy")
    return error(Errc::usage,
                 "f: 'npy' is a folder of arrays, and an answer is one file: ask for another format, or for "
                 "the process export");
  const ExportOptions options{.format = format};
  const auto target = answer_file(folder_, "." + format);
  BOOST_OUTCOME_TRYV(find_export_target(target, options));
  BOOST_OUTCOME_TRY(set, reader_.stored.cells(area, most, ask_));
  if (set.tiles.empty()) return error(Errc::bad_input, "no cell meets what is asked for");
  BOOST_OUTCOME_TRY(exported, export_cells(path_of(reader_.held.folder), reader_.stored.manifest(), set.mesh, set.tiles,
                                           target, options, ask_.stop));
  return file(exported.path);
}

Result<QuestionAnswer> Answering::interpolate() const {
  query::InterpolateOptions what{.value = word("value", dimension_ == 2 ? "z" : "")};
  if (what.value.empty()) return error(Errc::usage, "value: say which attribute of the vertices to interpolate");
  BOOST_OUTCOME_TRY(method, read("method", parse_method));
  what.method = method;
  BOOST_OUTCOME_TRY(weights, read("weights", [](const std::string& text) {
                      return text.empty() ? Result<bool>(false) : parse_switch(text);
                    }));
  what.weights = weights;
  BOOST_OUTCOME_TRY(options, many());
  options.values = true;
  options.weights = weights;
  BOOST_OUTCOME_TRY(answers, TextAnswers::make(options));
  BOOST_OUTCOME_TRY(points, points());
  BOOST_OUTCOME_TRY(values, reader_.stored.interpolate(points, what, ask_));
  BOOST_OUTCOME_TRYV(answers->add_values(points, values));
  return finished(*answers, options.format);
}

Result<QuestionAnswer> Answering::dem() const {
  DemOptions options{.memory_bytes = memory_bytes(), .threads = ask_.threads};
  BOOST_OUTCOME_TRY(res, read("res", [](const std::string& text) { return parse_distance(text); }));
  options.res = res;
  if (question_.options.contains("bbox")) {
    BOOST_OUTCOME_TRY(box, read("bbox", [](const std::string& text) { return parse_crop(text, 2); }));
    options.box = Bounds{box.lo, box.hi};
  }
  if (question_.options.contains("max-edge")) {
    BOOST_OUTCOME_TRY(longest, read("max-edge", [](const std::string& text) { return parse_distance(text); }));
    options.max_edge = longest;
  }
  options.value = word("value", "z");
  const std::string type = word("type", "float32");
  if (type != "float32" && type != "float64")
    return error(Errc::usage, "type: '" + type + "' is no type of pixels; there are float32 and float64");
  options.doubles = type == "float64";
  const Bounds& bounds = reader_.stored.manifest().bounds;
  BOOST_OUTCOME_TRY(grid, terrain::grid_over(options.res, options.box.value_or(bounds), bounds));
  const auto pixels = static_cast<std::uint64_t>(grid.width) * static_cast<std::uint64_t>(grid.height);
  if (pixels > limits_.pixels)
    return error(Errc::memory, "the raster has " + grouped(static_cast<std::uint64_t>(grid.width)) + " x " +
                                   grouped(static_cast<std::uint64_t>(grid.height)) + " pixels, and an answer " +
                                   grouped(limits_.pixels) + " at most: ask for a smaller bbox or a larger res");
  // The centres of the pixels: cells beside them have none. Those of a small box come from few tiles; when there are
  // too many for memory, all tiles are read, one after the other.
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
  return file(drawn.path);
}

Result<AnswerOptions> Answering::many() const {
  const std::string& type = question_.type;
  const std::string came = type == json_type ? "json" : type == "text/csv" ? "csv" : "npy";
  BOOST_OUTCOME_TRY(
      format, read("f", [&](const std::string& text) { return answer_format(text.empty() ? came : text, {}, false); }));
  return AnswerOptions{.format = format, .dimension = dimension_};
}

Result<QuestionAnswer> Answering::finished(TextAnswers& answers, AnswerFormat format) const {
  BOOST_OUTCOME_TRYV(answers.finish());
  std::string text = answers.take();
  if (format == AnswerFormat::json) {  // a document, not a line each
    for (char& c : text)
      if (c == '\n') c = ',';
    text.back() = ']';
    text = "{\"answers\":[" + text + "}\n";
  }
  return QuestionAnswer{.text = std::move(text), .type = type_of(format)};
}

Result<QuestionAnswer> Answering::file(const std::filesystem::path& path) const {
  BOOST_OUTCOME_TRY(opened, open_handle(path, O_RDONLY));
  BOOST_OUTCOME_TRY(sent, served(std::move(opened), path, media_type_of(path), ""));
  return QuestionAnswer{.text = {}, .file = sent};
}

Result<std::vector<Point>> Answering::points() const {
  if (question_.type == json_type) return points_in_json();
  if (question_.type == "text/csv") return points_in_file(".csv");
  return points_in_file(".npy");
}

Result<std::vector<Point>> Answering::points_in_json() const {
  const auto bad = [](const std::string& what) { return error(Errc::bad_input, "the body: " + what); };
  if (nested_too_deep(*question_.body)) return bad("lists are nested too deep for points");
  const auto document = nlohmann::json::parse(*question_.body, nullptr, false);
  if (document.is_discarded()) return bad("is not JSON");
  const auto list = document.is_object() ? document.find("points") : document.end();
  if (!document.is_object() || list == document.end() || !list->is_array() || list->empty())
    return bad("must be an object with a list 'points', that is not empty");
  std::vector<Point> points;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const auto& numbers = (*list)[i];
    const std::string place = "points[" + std::to_string(i) + "]";
    if (!numbers.is_array() || numbers.size() < static_cast<std::size_t>(dimension_) || numbers.size() > 3)
      return bad(place + ": must be a list of " + std::to_string(dimension_) + " numbers");
    Point p;
    for (std::size_t axis = 0; axis < numbers.size(); ++axis) {
      if (!numbers[axis].is_number()) return bad(place + ": has what is no number");
      if (static_cast<int>(axis) < dimension_) p[static_cast<int>(axis)] = numbers[axis].get<double>();
    }
    points.push_back(without_negative_zero(p));
  }
  return points;
}

// As the command reads such a file: there is one way to read each format.
Result<std::vector<Point>> Answering::points_in_file(const std::string& ending) const {
  const auto path = asked_points_file(folder_, ending);
  BOOST_OUTCOME_TRYV(write_whole(path, *question_.body));
  const auto read = [&]() -> Result<std::vector<Point>> {
    constexpr std::uint64_t unpacked_max = std::uint64_t{64} << 20;  // of a body that is an archive
    BOOST_OUTCOME_TRY(
        cloud,
        Cloud::open(
            {path.string()},
            {.dimension = dimension_, .heights = false, .spool_folder = folder_, .spool_bytes_max = unpacked_max},
            ask_.stop));
    std::vector<Point> points;
    BOOST_OUTCOME_TRY(counts, cloud.for_each_batch([&](CloudBatch& batch) -> Status {
      if (points.size() + batch.points.size() > limits_.points)
        return error(Errc::memory, path.string() + ": holds more than " + grouped(limits_.points) + " points");
      for (const auto& p : batch.points) points.push_back(p.at);
      return success();
    }));
    if (counts.read == 0) return error(Errc::bad_input, path.string() + ": holds no points");
    return points;
  };
  auto points = read();
  if (points) return points;
  std::string said = points.error().where;
  if (const auto at = said.find(path.string()); at != std::string::npos)
    said.replace(at, path.string().size(), "the body");
  return error(points.error().code, said);
}

}  // namespace tessera

#include "src/service/questions/open_question.h"

#include <fcntl.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/input/cloud/cloud.h"
#include "src/input/format.h"
#include "src/job/report/human.h"
#include "src/service/json.h"
#include "src/service/questions/answer_messages.h"

namespace tessera::service {
namespace {

std::string type_of(AnswerFormat format) {
  return format == AnswerFormat::json ? json_type : format == AnswerFormat::csv ? "text/csv" : "application/x-npy";
}

}  // namespace

OpenQuestion::OpenQuestion(const Reader& opened, const Question& asked, const QuestionLimits& given,
                           std::filesystem::path empty, std::stop_token stop)
    : reader(opened),
      question(asked),
      limits(given),
      folder(std::move(empty)),
      ask{.threads = given.threads, .stop = std::move(stop)},
      dimension(opened.stored.manifest().dimension) {}

std::string OpenQuestion::word(const std::string& key, const std::string& usual) const {
  const auto found = question.options.find(key);
  return found == question.options.end() ? usual : found->second;
}

Result<PointId> OpenQuestion::vertex() const {
  const auto id = parse_integer(question.vertex, 0, std::numeric_limits<std::int64_t>::max());
  if (!id) return error(Errc::usage, "a vertex is named by its source index, a whole number: " + id.error().where);
  return PointId{static_cast<std::uint64_t>(id.value())};
}

Result<std::optional<TileId>> OpenQuestion::owner() const {
  if (!question.options.contains("tile")) return std::optional<TileId>{};
  BOOST_OUTCOME_TRY(tile, read("tile", [](const std::string& text) { return parse_integer(text, 0, 999'999); }));
  return std::optional(TileId{static_cast<std::uint32_t>(tile)});
}

Result<std::vector<Point>> OpenQuestion::points() const {
  if (question.type == "application/json") return points_in_json();
  if (question.type == protobuf_type) return points_of(*question.body, dimension);
  if (question.type == "text/csv") return points_in_file(".csv");
  return points_in_file(".npy");
}

Result<std::vector<Point>> OpenQuestion::points_in_json() const {
  const auto bad = [](const std::string& what) { return error(Errc::bad_input, "the body: " + what); };
  if (nested_too_deep(*question.body)) return bad("lists are nested too deep for points");
  const auto document = parse_json(*question.body);
  if (document.is_discarded()) return bad("is not JSON");
  const auto list = document.is_object() ? document.find("points") : document.end();
  if (!document.is_object() || list == document.end() || !list->is_array() || list->empty())
    return bad("must be a JSON object with a list 'points' that is not empty");
  std::vector<Point> points;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const auto& numbers = (*list)[i];
    const std::string place = "points[" + std::to_string(i) + "]";
    if (!numbers.is_array() || numbers.size() < static_cast<std::size_t>(dimension) || numbers.size() > 3)
      return bad(place + ": must be a list of " + std::to_string(dimension) + " numbers");
    Point p;
    for (std::size_t axis = 0; axis < numbers.size(); ++axis) {
      if (!numbers[axis].is_number()) return bad(place + ": has a coordinate that is not a number");
      if (static_cast<int>(axis) < dimension) p[static_cast<int>(axis)] = numbers[axis].get<double>();
    }
    points.push_back(without_negative_zero(p));
  }
  return points;
}

// As the command reads such a file, so that each format has one reader.
Result<std::vector<Point>> OpenQuestion::points_in_file(const std::string& ending) const {
  // If the content decided, a body could have any file format, and callers would reach the readers of all formats.
  const auto bytes = std::as_bytes(std::span(*question.body));
  const auto wanted = ending == ".npy" ? FileFormat::npy : FileFormat::text;
  if (format_of(bytes.first(std::min(bytes.size(), format_bytes)), "body" + ending, bytes.size()) != wanted)
    return error(Errc::bad_input, std::string("the body: is not ") + (ending == ".npy" ? "a NumPy array" : "text"));
  const auto path = asked_points_file(folder, ending);
  BOOST_OUTCOME_TRYV(write_whole(path, *question.body));
  const auto read = [&]() -> Result<std::vector<Point>> {
    BOOST_OUTCOME_TRY(cloud, Cloud::open({path.string()}, {.dimension = dimension, .heights = false}, ask.stop));
    std::vector<Point> points;
    BOOST_OUTCOME_TRY(counts, cloud.for_each_batch([&](CloudBatch& batch) -> Status {
      if (points.size() + batch.points.size() > limits.points)
        return error(Errc::memory, path.string() + ": holds more than " + grouped(limits.points) +
                                       " points: send them in several requests");
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

Result<query::Area> OpenQuestion::area() const {
  query::Area area;
  if (question.body) {
    if (nested_too_deep(*question.body)) return error(Errc::usage, "the body: lists are nested too deep for GeoJSON");
    BOOST_OUTCOME_TRY(polygon, query::Polygon::of_geojson(*question.body, "the body"));
    BOOST_OUTCOME_TRYV(polygon.place().check_in(reader.stored.manifest().crs, reader.stored.manifest().bounds));
    constexpr double inf = std::numeric_limits<double>::infinity();
    area.box = polygon.bounds();
    area.box.lo.z = -inf;
    area.box.hi.z = inf;
    area.polygon = std::move(polygon);
    return area;
  }
  if (!question.options.contains("bbox"))
    return error(Errc::usage, "give the box as bbox=xmin,ymin,xmax,ymax, or send a polygon");
  BOOST_OUTCOME_TRY(box, read("bbox", [&](const std::string& text) { return parse_crop(text, dimension); }));
  area.box = {box.lo, box.hi};
  return area;
}

Result<query::CellLimits> OpenQuestion::limits_of_cells() const {
  query::CellLimits most{.bytes_max = memory_bytes(), .cells_max = limits.usual_cells};
  if (!question.options.contains("limit")) return most;
  const auto number = [&](const std::string& text) {
    return parse_integer(text, 1, static_cast<std::int64_t>(limits.cells));
  };
  BOOST_OUTCOME_TRY(limit, read("limit", number));
  most.cells_max = static_cast<std::uint64_t>(limit);
  return most;
}

Result<exports::CellSizes> OpenQuestion::sizes() const {
  const auto distance = [](const std::string& text) { return parse_distance(text); };
  exports::CellSizes sizes;
  if (question.options.contains("max-edge")) {
    BOOST_OUTCOME_TRY(longest, read("max-edge", distance));
    sizes.max_edge = longest;
  }
  if (question.options.contains("max-radius")) {
    BOOST_OUTCOME_TRY(largest, read("max-radius", distance));
    sizes.max_radius = largest;
  }
  return sizes;
}

Result<AnswerOptions> OpenQuestion::many() const {
  const std::string& type = question.type;
  // Protobuf is answered as JSON is.
  const bool json = question.as_message || type == json_type || type == protobuf_type;
  const std::string came = json ? "json" : type == "text/csv" ? "csv" : "npy";
  BOOST_OUTCOME_TRY(
      format, read("f", [&](const std::string& text) { return answer_format(text.empty() ? came : text, {}, false); }));
  return AnswerOptions{.format = format, .dimension = dimension, .final = is_part()};
}

Result<QuestionAnswer> OpenQuestion::file(const std::filesystem::path& path, bool final) const {
  BOOST_OUTCOME_TRY(opened, open_handle(path, O_RDONLY));
  BOOST_OUTCOME_TRY(sent, served(std::move(opened), path, media_type_of(path), ""));
  return QuestionAnswer{.text = {}, .file = sent, .final = final};
}

QuestionAnswer in_bytes(std::string message, bool final) {
  return {.text = std::move(message), .type = protobuf_type, .final = final};
}

Result<QuestionAnswer> finished(TextAnswers& answers, AnswerFormat format, bool final) {
  BOOST_OUTCOME_TRYV(answers.finish());
  std::string text = answers.take();
  if (format == AnswerFormat::json) {  // one document, not one line an answer
    for (char& c : text)
      if (c == '\n') c = ',';
    text.back() = ']';
    text = "{\"answers\":[" + text + "}\n";
  }
  return QuestionAnswer{.text = std::move(text), .type = type_of(format), .final = final};
}

}  // namespace tessera::service

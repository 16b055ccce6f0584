#include "src/service/answering.h"

#include <fcntl.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "src/base/files/names.h"
#include "src/base/option.h"
#include "src/job/arguments.h"
#include "src/result/query/answer_text.h"
#include "src/service/answer_messages.h"
#include "src/service/beneath.h"
#include "src/service/json.h"

namespace tessera {
namespace {

constexpr const char* json_type = "application/json";

Result<query::Method> parse_method(const std::string& text) {
  if (text.empty() || text == "linear") return query::Method::linear;
  if (text == "natural") return query::Method::natural;
  return error(Errc::usage, "'" + text + "' is not a method of interpolation; the methods are linear and natural");
}

std::string type_of(AnswerFormat format) {
  return format == AnswerFormat::json ? json_type : format == AnswerFormat::csv ? "text/csv" : "application/x-npy";
}

bool all_final(const auto& answers) {
  return std::all_of(answers.begin(), answers.end(), [](const auto& answer) { return answer.final; });
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
    case Question::About::contours:
      return contours();
    case Question::About::profile:
      return profile();
    case Question::About::features:
      return features();
    case Question::About::map_tile:
      return map_tile();
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
  return location(p, details, cells[0].final);
}

QuestionAnswer Answering::in_bytes(std::string message, bool final) {
  return {.text = std::move(message), .type = protobuf_type, .final = final};
}

QuestionAnswer Answering::location(const Point& p, const std::optional<query::CellDetails>& details, bool final) const {
  const auto told = is_part() ? std::optional(final) : std::nullopt;
  final = final && (!details || all_final(details->neighbors));
  if (question_.as_message) return in_bytes(message_of(p, dimension_, details, told).SerializeAsString(), final);
  return {.text = json_of(p, dimension_, details, told), .type = json_type, .final = final};
}

Result<QuestionAnswer> Answering::locate_many() const {
  BOOST_OUTCOME_TRY(options, many());
  BOOST_OUTCOME_TRY(answers, TextAnswers::make(options));
  BOOST_OUTCOME_TRY(points, points());
  BOOST_OUTCOME_TRY(cells, reader_.stored.locate(points, ask_));
  const bool final = all_final(cells);
  if (question_.as_message) return in_bytes(answers_message(points, cells, options), final);
  BOOST_OUTCOME_TRYV(answers->add_cells(points, cells));
  return finished(*answers, options.format, final);
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
  if (question_.as_message)
    return in_bytes(message_of(asked, dimension_, star, is_part()).SerializeAsString(), star.final);
  return QuestionAnswer{.text = json_of(asked, dimension_, star, is_part()), .type = json_type, .final = star.final};
}

Result<query::Area> Answering::area() const {
  query::Area area;
  if (question_.body) {
    if (nested_too_deep(*question_.body)) return error(Errc::usage, "the body: lists are nested too deep for GeoJSON");
    BOOST_OUTCOME_TRY(polygon, query::Polygon::of_geojson(*question_.body, "the body"));
    BOOST_OUTCOME_TRYV(polygon.place().check_in(reader_.stored.manifest().crs, reader_.stored.manifest().bounds));
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
  // The name of the file does not matter, but a name without an ending would mean a folder.
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
  return file(exported.path, set.final);
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
  const bool final = all_final(values);
  if (question_.as_message) return in_bytes(answers_message(points, values, options), final);
  BOOST_OUTCOME_TRYV(answers->add_values(points, values));
  return finished(*answers, options.format, final);
}

Result<AnswerOptions> Answering::many() const {
  const std::string& type = question_.type;
  // Protobuf is answered as JSON is.
  const bool json = question_.as_message || type == json_type || type == protobuf_type;
  const std::string came = json ? "json" : type == "text/csv" ? "csv" : "npy";
  BOOST_OUTCOME_TRY(
      format, read("f", [&](const std::string& text) { return answer_format(text.empty() ? came : text, {}, false); }));
  return AnswerOptions{.format = format, .dimension = dimension_, .final = is_part()};
}

Result<QuestionAnswer> Answering::finished(TextAnswers& answers, AnswerFormat format, bool final) const {
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

Result<QuestionAnswer> Answering::file(const std::filesystem::path& path, bool final) const {
  BOOST_OUTCOME_TRY(opened, open_handle(path, O_RDONLY));
  BOOST_OUTCOME_TRY(sent, served(std::move(opened), path, media_type_of(path), ""));
  return QuestionAnswer{.text = {}, .file = sent, .final = final};
}

}  // namespace tessera

// The question profile: the heights of a 2D result along a line.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/base/json/json_text.h"
#include "src/job/arguments.h"
#include "src/result/query/geojson.h"
#include "src/result/terrain/profile.h"
#include "src/service/beneath.h"
#include "src/service/json.h"
#include "src/service/questions/answer_messages.h"
#include "src/service/questions/open_question.h"
#include "src/service/questions/rows.h"

namespace tessera::service {
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

Result<QuestionAnswer> answer_profile(const OpenQuestion& asked) {
  std::vector<Point> line;
  if (asked.question.body) {
    if (nested_too_deep(*asked.question.body))
      return error(Errc::usage, "the body: lists are nested too deep for GeoJSON");
    BOOST_OUTCOME_TRY(lines, query::of_geojson(*asked.question.body, "the body", query::GeoJson::lines));
    if (lines.lists.size() > 1)
      return error(Errc::bad_input, "the body: has " + std::to_string(lines.lists.size()) + " lines, not one");
    BOOST_OUTCOME_TRYV(lines.place.check_in(asked.reader.stored.manifest().crs, asked.reader.stored.manifest().bounds));
    line = std::move(lines.lists[0]);
  } else {
    BOOST_OUTCOME_TRY(points, asked.read("line", parse_line));
    line = std::move(points);
  }
  ProfileOptions options{.memory_bytes = asked.memory_bytes(), .stop = asked.ask.stop};
  BOOST_OUTCOME_TRYV(asked.read_surface(options));
  if (asked.question.options.contains("digits")) {
    BOOST_OUTCOME_TRY(digits, asked.read("digits", parse_digits));
    options.digits = digits;
  }
  const std::string format = asked.word("f", "csv");
  if (format != "csv" && format != "json" && format != "geojson")
    return error(Errc::usage, "f: '" + format + "' is not a format of profiles; the formats are csv, json and geojson");
  BOOST_OUTCOME_TRY(points, tessera::profile(asked.reader.stored, path_of(asked.reader.held.folder), line, options));
  Bounds box;
  for (const Point& p : line) box.add(p);
  if (asked.question.as_message)
    return in_bytes(message_of(points).SerializeAsString(), asked.reader.stored.knows(box));
  QuestionAnswer answer{.type = "text/csv", .final = asked.reader.stored.knows(box)};
  if (format == "csv") answer.text = to_csv(points, options);
  if (format == "json") answer.text = json_of(points, options.value);
  if (format == "geojson") answer.text = geojson_of(points);
  if (format != "csv") answer.type = format == "json" ? "application/json" : "application/geo+json";
  return answer;
}

}  // namespace tessera::service

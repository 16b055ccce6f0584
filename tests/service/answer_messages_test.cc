#include "src/service/questions/answer_messages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "src/result/query/answer_text.h"
#include "src/result/query/answers.h"

namespace tessera::service {
namespace {

using Json = nlohmann::json;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint64_t large = 18'446'744'073'709'551'557U;  // no double has it

Json told(const Message& message);

Json told(const Message& message, const FieldDescriptor& field, int at) {
  const auto& all = *message.GetReflection();
  const bool list = field.is_repeated();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return told(list ? all.GetRepeatedMessage(message, &field, at) : all.GetMessage(message, &field));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return list ? all.GetRepeatedDouble(message, &field, at) : all.GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_UINT64:
      return list ? all.GetRepeatedUInt64(message, &field, at) : all.GetUInt64(message, &field);
    case FieldDescriptor::CPPTYPE_UINT32:
      return all.GetUInt32(message, &field);
    case FieldDescriptor::CPPTYPE_BOOL:
      return all.GetBool(message, &field);
    default:
      ADD_FAILURE() << field.full_name();
      return {};
  }
}

// What the message says, under the names of JSON: the rules are those of proto/query.proto.
Json told(const Message& message) {
  Json object = Json::object();
  const auto& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const auto& field = *type.field(i);
    if (!field.is_repeated()) {
      if (!field.has_presence() || message.GetReflection()->HasField(message, &field))
        object[field.name()] = told(message, field, 0);
      continue;
    }
    for (int at = 0; at < message.GetReflection()->FieldSize(message, &field); ++at)
      object[field.name()].push_back(told(message, field, at));
  }
  return type.name() == "Cell" && object.empty() ? Json(nullptr) : object;
}

// Without the members that are null, or lists of nothing: a message does not have them.
Json plain(const std::string& text) {
  Json all = Json::parse(text);
  for (auto at = all.begin(); at != all.end();)
    at = at->is_null() || (at->is_array() && at->empty()) ? all.erase(at) : std::next(at);
  return all;
}

query::Cell cell_of(std::uint32_t tile, std::int32_t place, std::uint64_t first, bool final = true) {
  return {TileId{tile}, place, {PointId{first}, PointId{large}, PointId{2}, PointId{0}}, final};
}
query::Vertex vertex_of(std::uint64_t id) { return {PointId{id}, TileId{0}, {0.1, -1e300, 5e-324}}; }
const query::Cell unknown{TileId{}, -1, {}, false};

TEST(AnswerMessages, ALocationIsThatOfJson) {
  query::CellDetails found{.cell = cell_of(7, 0, 0),
                           .vertices = {vertex_of(0), vertex_of(large), vertex_of(2), vertex_of(9)},
                           .neighbors = {cell_of(0, 0x7fffffff, 3), {}, unknown, cell_of(1, 1, 1, false)}};
  const Point p{1. / 3, 2, 1e-7};
  for (const int dimension : {2, 3})
    for (const auto final : {std::optional<bool>(), std::optional(false), std::optional(true)}) {
      EXPECT_EQ(told(message_of(p, dimension, found, final)), plain(json_of(p, dimension, found, final)));
      EXPECT_EQ(told(message_of(p, dimension, {}, final)), plain(json_of(p, dimension, {}, final)));
      EXPECT_FALSE(message_of(p, dimension, {}, final).has_cell());
    }
  EXPECT_EQ(message_of(p, 3, found).vertices(1).id(), large);
}

TEST(AnswerMessages, AStarIsThatOfJson) {
  query::Star star{.vertex = vertex_of(large),
                   .cells = {cell_of(0, 0, 5), cell_of(3, 2, 1, false)},
                   .neighbors = {vertex_of(0), vertex_of(large)}};
  for (const double volume : {0.0, 0.1, inf, nan})
    for (const bool part : {false, true}) {
      star.voronoi_volume = volume;
      star.final = volume == 0;
      EXPECT_EQ(told(message_of(PointId{large - 1}, 3, star, part)), plain(json_of(PointId{large - 1}, 3, star, part)));
      EXPECT_EQ(message_of(PointId{0}, 2, star).has_voronoi_volume(), std::isfinite(volume));
    }
}

// By the lines of JSON, with the same options.
template <class Add>
void expect_as_json(const std::string& bytes, std::size_t count, AnswerOptions options, const Add& add) {
  options.format = AnswerFormat::json;
  auto text = TextAnswers::make(options).value();
  ASSERT_TRUE(add(*text) && text->finish());
  proto::Answers answers;
  ASSERT_TRUE(answers.ParseFromString(bytes));
  ASSERT_EQ(static_cast<std::size_t>(answers.answers_size()), count);
  std::istringstream lines(text->take());
  std::string line;
  for (const auto& answer : answers.answers()) {
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(told(answer), plain(line));
  }
}

TEST(AnswerMessages, ManyAnswersAreThoseOfJson) {
  const std::vector<Point> points{{0.1, 2, 3}, {-1e300, 5e-324, 0}, {7, 8, 9}};
  const std::vector<query::Cell> cells{cell_of(0, 0, large), {}, unknown};
  const std::vector<query::Interpolated> values{
      {0.1, true, {PointId{large}, PointId{0}}, {0.25, 0.75}}, {nan, false, {}, {}}, {0, true, {PointId{3}}, {1}}};
  for (const int dimension : {2, 3})
    for (const bool final : {false, true}) {
      AnswerOptions options{.dimension = dimension, .final = final};
      expect_as_json(answers_message(points, cells, options), 3, options,
                     [&](Answers& to) { return to.add_cells(points, cells).has_value(); });
      options.values = true;
      for (const bool weights : {false, true}) {
        options.weights = weights;
        expect_as_json(answers_message(points, values, options), 3, options,
                       [&](Answers& to) { return to.add_values(points, values).has_value(); });
      }
    }
}

TEST(AnswerMessages, AProfileHasItsPoints) {
  const std::vector<ProfilePoint> points{{0, 1, 2, 0.1, 0}, {0.3, 4, 5, nan, large}};
  const proto::Profile profile = message_of(points);
  EXPECT_EQ(told(profile)["points"], Json::parse(R"([{"distance":0.0,"x":1.0,"y":2.0,"value":0.1,"part":0},
                            {"distance":0.3,"x":4.0,"y":5.0,"part":18446744073709551557}])"));
}

std::string refusal(const proto::Points& points, int dimension) {
  const auto read = points_of(points.SerializeAsString(), dimension);
  if (read) return "";
  EXPECT_EQ(read.error().code, Errc::bad_input);
  return read.error().where;
}

TEST(AnswerMessages, PointsAreReadAsTheyAre) {
  proto::Points points;
  for (const double x : {0.1, -0.0, 1e300}) {
    points.add_x(x);
    points.add_y(-x);
  }
  const auto flat = points_of(points.SerializeAsString(), 2);
  ASSERT_TRUE(flat) << flat.error().where;
  EXPECT_EQ(flat.value(), (std::vector<Point>{{0.1, -0.1, 0}, {0, 0, 0}, {1e300, -1e300, 0}}));
  EXPECT_FALSE(std::signbit(flat.value()[1].x));
  EXPECT_EQ(refusal(points, 3), "the body: has 3 values of x, but 0 of z");
  for (const double z : {1., nan, 3.}) points.add_z(z);
  EXPECT_EQ(points_of(points.SerializeAsString(), 2).value(), flat.value()) << "z has no effect";
  EXPECT_EQ(refusal(points, 3), "the body: point 1 has a coordinate that is not finite");
  points.set_z(1, 2);
  EXPECT_EQ(points_of(points.SerializeAsString(), 3).value()[1], (Point{0, 0, 2}));
}

TEST(AnswerMessages, WrongPointsAreRefusedWithASentence) {
  proto::Points points;
  EXPECT_EQ(refusal(points, 2), "the body: has no points: its list x is empty");
  points.add_x(1);
  EXPECT_EQ(refusal(points, 2), "the body: has 1 values of x, but 0 of y");
  for (const double y : {inf, -inf, nan}) {
    points.mutable_y()->Clear();
    points.add_y(y);
    EXPECT_EQ(refusal(points, 2), "the body: point 0 has a coordinate that is not finite");
  }
  points.set_y(0, 2);
  const std::string bytes = points.SerializeAsString();
  ASSERT_TRUE(points_of(bytes, 2));
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_FALSE(points_of(std::string_view(bytes).substr(0, length), 2)) << length;
  // Nested deeper than any message is: groups in groups.
  EXPECT_EQ(points_of(std::string(1 << 20, '\x7b'), 2).error().where,
            "the body: is not a protobuf message tessera.proto.Points");
  EXPECT_FALSE(points_of(R"({"points": [[1, 2]]})", 2));
}

}  // namespace
}  // namespace tessera::service

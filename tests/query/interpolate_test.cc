#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/query/cgal_answers.h"
#include "tests/query/query_testing.h"

namespace tessera {
namespace {

using query::Interpolated;
using query::Method;
using test::QuerySample;

std::vector<Interpolated> interpolated(const query::StoredTriangulation& result, const std::vector<Point>& points,
                                       const char* value, Method method) {
  auto values = result.interpolate(points, {.value = value, .method = method, .weights = true}, {.threads = 2});
  EXPECT_TRUE(values) << (values ? "" : values.error().where);
  return values ? std::move(values).value() : std::vector<Interpolated>(points.size());
}

class Interpolation : public testing::TestWithParam<test::SampleKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Interpolation, testing::ValuesIn(test::sample_kinds()),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });

// What weights must be, whatever the method: they give back the point, and are those that made the value.
void check_weights(const QuerySample& sample, const Point& q, const Interpolated& answer, double tolerance) {
  double all = 0, wave = 0;
  Point back;
  for (std::size_t i = 0; i < answer.weights.size(); ++i) {
    const Point& p = sample.points()[answer.vertices[i].value];
    EXPECT_GE(answer.weights[i], 0);
    all += answer.weights[i];
    for (int axis = 0; axis < 3; ++axis) back[axis] += answer.weights[i] * p[axis];
    wave += answer.weights[i] * static_cast<double>(test::wave_at(p));
  }
  EXPECT_NEAR(all, 1, 1e-12);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(back[axis], q[axis], tolerance);
  EXPECT_NEAR(answer.value, wave, 1e-9);
}

TEST_P(Interpolation, ReproducesLinearFunctions) {
  const QuerySample sample(GetParam(), 60);
  const auto result = sample.open();
  const auto questions = sample.questions(120, 10);
  double extent = 1;
  for (const Point& p : sample.points())
    for (int axis = 0; axis < 3; ++axis) extent = std::max(extent, std::abs(p[axis]));
  for (const auto& [method, tolerance] : {std::pair(Method::linear, 1e-12), std::pair(Method::natural, 1e-8)}) {
    const auto values = interpolated(result, questions, "plane", method);
    const auto waves = interpolated(result, questions, "wave", method);
    for (std::size_t i = 0; i < questions.size(); ++i) {
      const bool inside = sample.right_cell(questions[i]) != nullptr;
      ASSERT_EQ(std::isnan(values[i].value), !inside) << i;
      if (!inside) continue;
      EXPECT_NEAR(values[i].value, test::plane_at(questions[i]), tolerance * extent * 4) << i;
      check_weights(sample, questions[i], waves[i], tolerance * extent);
    }
  }
}

TEST_P(Interpolation, GivesTheVertexItsOwnValue) {
  const QuerySample sample(GetParam());
  for (const Method method : {Method::linear, Method::natural}) {
    const auto values = interpolated(sample.open(), sample.points(), "wave", method);
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_EQ(values[i].value, static_cast<double>(test::wave_at(sample.points()[i])));
      EXPECT_EQ(values[i].vertices, std::vector{PointId{i}});
    }
  }
}

TEST_P(Interpolation, HasTheNaturalNeighborsOfCgal) {
  const QuerySample sample(GetParam(), 60);
  const test::CgalAnswers cgal(sample.points(), sample.dimension());
  std::vector<Point> inside;
  // Anywhere, and in the middle of edges and facets: not on vertices.
  for (const Point& q : sample.questions(60, 11))  // CGAL takes 10 ms for one
    if (sample.right_cell(q) != nullptr &&
        std::find(sample.points().begin(), sample.points().end(), q) == sample.points().end())
      inside.push_back(q);
  const auto values = interpolated(sample.open(), inside, "wave", Method::natural);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const auto right = cgal.natural(inside[i]);
    std::size_t linear = 0;  // on the hull, or spoilt: as many as a face has
    for (const double weight : values[i].weights) linear += weight > 1e-9 ? 1 : 0;
    if (right.empty() || linear <= static_cast<std::size_t>(sample.dimension()) + 1) continue;
    ++compared;
    for (const auto& [id, weight] : right) {
      const auto at = std::find(values[i].vertices.begin(), values[i].vertices.end(), id);
      const double got = at == values[i].vertices.end()
                             ? 0
                             : values[i].weights[static_cast<std::size_t>(at - values[i].vertices.begin())];
      EXPECT_NEAR(got, weight, 1e-9) << i;
    }
  }
  if (GetParam().cloud == "uniform") {
    EXPECT_GT(compared, inside.size() / 2);
  }
}

TEST(Interpolate, SaysWhichAttributesThereAre) {
  const QuerySample sample({.cloud = "uniform", .dimension = 2, .number = 2}, 50);
  const auto values = sample.open().interpolate({}, {.value = "height"}, {});
  ASSERT_FALSE(values);
  EXPECT_EQ(values.error().code, Errc::usage);
  EXPECT_NE(values.error().where.find("wave, plane"), std::string::npos) << values.error().where;
}

TEST(Interpolate, GivesTheSameValuesWithHardlyAnyMemory) {
  const QuerySample sample({.cloud = "uniform", .dimension = 3, .tiles = test::Tiles::random, .number = 4}, 300);
  const auto questions = sample.questions(300, 12);
  const auto plenty = interpolated(sample.open(), questions, "wave", Method::natural);
  const auto little = interpolated(sample.open(1), questions, "wave", Method::natural);
  for (std::size_t i = 0; i < questions.size(); ++i) {
    EXPECT_EQ(plenty[i].vertices, little[i].vertices);
    EXPECT_TRUE(plenty[i].value == little[i].value || std::isnan(plenty[i].value));
  }
}

}  // namespace
}  // namespace tessera

// tessera::update(); tests/update compares changed results with triangulations from scratch.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cloud;
using testing::failure_of;
using testing::TemporaryHome;

// A coordinate that is not finite keeps the ids of the others.
TEST(UpdateOf, AResultIsTheTriangulationOfThePointsThatAreLeft) {
  const TemporaryHome home;
  const std::filesystem::path to = home.path() / "next";
  auto points = cloud("uniform", 3, 400);
  const std::vector<double> first(points.begin(), points.begin() + 900), others(points.begin() + 900, points.end());
  const auto t = triangulate(first, TriangulationOptions().tiles(5));
  const std::vector<std::uint64_t> ids{7, 30};
  const auto request = UpdateRequest().add(others).remove(ids).output(to).threads(2);
  const UpdateReport report = update(t, request);
  EXPECT_EQ(report.first_id, 300u);
  EXPECT_EQ(report.removed, 2u);
  EXPECT_EQ(report.added, others.size() / 3);
  const auto next = Triangulation::open(to);
  EXPECT_EQ(report.tiles, next.tiles());
  for (const std::uint64_t id : ids) points[3 * id] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(next.digest(), triangulate(points, TriangulationOptions().skip_invalid(true)).digest());
  const std::string again = failure_of([&] { update(t, request); }).what();
  EXPECT_NE(again.find("exists already"), std::string::npos);
}

}  // namespace
}  // namespace tessera

#include "src/result/verify/periodic_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <vector>

#include "src/base/image.h"
#include "src/result/tile_source.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using Exact = VolumeSum::Exact;

Exact volume(const std::vector<Point>& p) {
  const auto e = [&](std::size_t i, int axis) -> Exact { return Exact(p[i][axis]) - Exact(p[0][axis]); };
  if (p.size() == 3) return e(1, 0) * e(2, 1) - e(1, 1) * e(2, 0);
  return e(1, 0) * (e(2, 1) * e(3, 2) - e(2, 2) * e(3, 1)) - e(1, 1) * (e(2, 0) * e(3, 2) - e(2, 2) * e(3, 0)) +
         e(1, 2) * (e(2, 0) * e(3, 1) - e(2, 1) * e(3, 0));
}

TEST(VolumeSum, IsExactForCoordinatesOfAllSizes) {
  std::mt19937_64 rng(1);
  for (const int spread : {0, 10, 50, 300}) {
    for (const std::size_t corners : {3, 4}) {
      VolumeSum sum;
      Exact expected = 0;
      for (int i = 0; i < 300; ++i) {
        std::vector<Point> p(corners);
        for (Point& at : p) {
          for (int axis = 0; axis < 3; ++axis) {
            const double digits = static_cast<double>(static_cast<std::int64_t>(rng()) >> (rng() % 64));
            at[axis] =
                std::ldexp(digits, spread == 0 ? 0 : static_cast<int>(rng() % static_cast<unsigned>(spread)) - 90);
          }
          if (corners == 3) at.z = 0;
        }
        sum.add(p);
        expected += volume(p);
      }
      EXPECT_EQ(sum.value(), expected) << spread;
    }
  }
}

// A square of two triangles, with a period along both axes, one, or none of them.
class Space {
 public:
  explicit Space(const Period& period)
      : space_(2, period, TileSource::draft("out", Manifest{}), fs::temp_directory_path(), 1 << 20, {}) {
    for (const Point& p : {Point{0, 0, 0}, Point{4, 0, 0}, Point{4, 4, 0}, Point{0, 4, 0}}) space_.add_vertex(p);
  }
  void triangle(const Point& a, const Point& b, const Point& c) { space_.add_main_cell(std::vector{a, b, c}); }
  Status edge(const Point& a, const Point& b) { return space_.add_hull_facet(std::vector{a, b}, {}, no_ids); }
  Status finish() { return space_.finish(); }

 private:
  static constexpr IdSet no_ids{padding_id, padding_id, padding_id, padding_id};
  PeriodicSpace space_;
};

TEST(PeriodicSpace, CellsFillAPeriodOnce) {
  const auto filled = [](int lower, int upper) {
    Space space(Period{{4, 4, 0}});
    for (int i = 0; i < lower; ++i) space.triangle({0, 0, 0}, {4, 0, 0}, {4, 4, 0});
    for (int i = 0; i < upper; ++i) space.triangle({0, 0, 0}, {4, 4, 0}, {0, 4, 0});
    return space.finish();
  };
  EXPECT_TRUE(filled(1, 1));
  const auto less = filled(1, 0), more = filled(2, 2);
  ASSERT_FALSE(less);
  EXPECT_NE(less.error().where.find("add up to less than the volume of a period"), std::string::npos);
  ASSERT_FALSE(more);
  EXPECT_NE(more.error().where.find("add up to more than the volume of a period"), std::string::npos);
  EXPECT_FALSE(Space(Period{{4, 4, 0}}).edge({0, 0, 0}, {4, 0, 0}));
}

TEST(PeriodicSpace, HullFacetsLieInTheBorder) {
  const auto with_edge = [](const Point& a, const Point& b) {
    Space space(Period{{4, 0, 0}});
    space.triangle({0, 0, 0}, {4, 0, 0}, {4, 4, 0});
    space.triangle({0, 0, 0}, {4, 4, 0}, {0, 4, 0});
    EXPECT_TRUE(space.edge(a, b));
    return space.finish();
  };
  EXPECT_TRUE(with_edge({0, 4, 0}, {4, 4, 0}));
  EXPECT_TRUE(with_edge({0, 0, 0}, {4, 0, 0}));
  EXPECT_FALSE(with_edge({0, 0, 0}, {4, 4, 0}));
  EXPECT_FALSE(with_edge({0, 2, 0}, {4, 2, 0}));
}

TEST(PeriodicSpace, VerticesSpanTheOpenAxes) {
  PeriodicSpace space(3, Period{{1, 0, 0}}, TileSource::draft("out", Manifest{}), fs::temp_directory_path(), 1 << 20,
                      {});
  for (const double t : {0.0, 1.0, 2.0, 3.0}) space.add_vertex({0, t, t});
  EXPECT_FALSE(space.finish());
}

}  // namespace
}  // namespace tessera::test

// The labels of a result in many tiles against a flow, by another library, through the graph of the whole.
#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "tests/store/sample_result.h"
#include "tests/surface/triangles_of_result.h"
#include "tests/surface/whole_surface.h"

namespace tessera::surface {
namespace {

TEST(SurfaceCut, IsTheSmallestOneThatAnotherLibraryFinds) {
  std::uint64_t undecided = 0, found_in_all = 0;
  for (unsigned seed = 0; seed < 24; ++seed) {
    std::mt19937_64 random(seed);
    const auto shape = static_cast<test::Shape>(seed % 4);
    auto points = test::sample_points(shape, 3, 100 + random() % 500, seed);
    // Birds, whose edges are far longer than those of the rest: their scales are bounded.
    if (seed % 8 == 7)
      for (int i = 0; i < 6; ++i)
        points.push_back({2.5 + static_cast<double>(random() % 15), 2.5 + static_cast<double>(random() % 15),
                          20 + static_cast<double>(random() % 20)});
    Bounds bounds;
    for (const Point& p : points) bounds.add(p);
    const double size = bounds.hi.x - bounds.lo.x;
    SensorOptions sensors;
    if (seed % 3 == 1)
      sensors = {.kind = SensorOptions::Kind::positions,
                 .positions = {{bounds.lo.x - size, bounds.lo.y - size / 3, bounds.hi.z + size / 2},
                               {bounds.hi.x + size / 7, bounds.hi.y + size, bounds.hi.z + size / 5}}};
    Energy energy{.lambda = static_cast<double>(random() % 40) / 4,
                  .alpha = 32,
                  .ray_length = 3.0 + seed % 8,
                  .sigma = seed % 4 == 3 ? 0 : size / static_cast<double>(5 + random() % 40)};
    const CutRule rule{.lower_inside = seed % 5 != 0, .unknown_inside = seed % 7 != 0};
    const auto wanted = surface_of_whole(points, sensors, energy, rule);
    const std::uint32_t tiles = 2 + static_cast<std::uint32_t>(random() % 5);
    const test::TemporaryFolder folder;
    test::store_sample(folder.path() / "out", test::sample_tiles(points, 3, tiles));
    SurfaceOptions options;
    options.energy = energy;
    options.sensors = sensors;
    options.bottom = rule.lower_inside ? SurfaceOptions::Bottom::closed : SurfaceOptions::Bottom::free;
    options.unknown_inside = rule.unknown_inside;
    options.memory_bytes = std::uint64_t{1} << 30;
    options.threads = 2 + seed % 2;  // two: all cells are decided at once
    const Triangles found = triangles_of(folder.path() / "out", options);
    ASSERT_EQ(found.main, wanted) << "seed " << seed;
    undecided += found.undecided;
    found_in_all += found.main.size();
  }
  EXPECT_GT(undecided, 0u);
  EXPECT_GT(found_in_all, 1000u);
}

}  // namespace
}  // namespace tessera::surface

// Triangulation::measure() and columns(); the values are tested in tests/measure.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "tests/api/api_testing.h"

namespace tessera {
namespace {

using testing::cloud;
using testing::failure_of;

TEST(MeasureOf, TheVersionBeforeCanBeOpenedByItsNumber) {
  auto t = triangulate(cloud("uniform", 2, 200), TriangulationOptions().dimension(2).max_points_per_tile(50));
  t.measure(MeasureRequest().volume(true));
  const auto old = Triangulation::open(t.folder(), 1), same = Triangulation::open(t.folder(), 2);
  EXPECT_TRUE(old.columns().empty());
  EXPECT_EQ(same.columns().size(), 2u);
  EXPECT_EQ(old.digest(), t.digest());
  const auto failure = failure_of([&] { Triangulation::open(t.folder(), 3); });
  EXPECT_EQ(failure.cause(), Cause::usage);
  EXPECT_NE(std::string(failure.what()).find("the versions 1 and 2 can be read"), std::string::npos) << failure.what();
}

TEST(MeasureOf, AResultIsANewVersionOfItAndCopiesStayAtTheOldOne) {
  TriangulationOptions options;
  options.max_points_per_tile(100);
  auto t = triangulate(cloud("uniform", 3, 400), options);
  const Triangulation old = t;
  EXPECT_TRUE(t.columns().empty());
  const MeasureReport report = t.measure(MeasureRequest().volume(true).threads(2).memory_bytes(std::uint64_t{1} << 30));
  EXPECT_TRUE(report.made);
  ASSERT_EQ(t.columns().size(), 2u);
  EXPECT_EQ(t.columns()[0].name, "volume");
  EXPECT_TRUE(t.columns()[0].of_cells);
  EXPECT_EQ(t.columns()[1].name, "star_volume");
  double total = 0;
  for (std::size_t i = 0; i < t.tiles(); ++i) {
    const Tile tile = t.tile(i), before = old.tile(i);
    EXPECT_TRUE(before.cell_columns().empty());
    ASSERT_EQ(tile.cell_columns().size(), 1u);
    EXPECT_EQ(tile.cell_columns()[0].type, "float64");
    for (std::size_t cell = 0; cell < tile.ghost().size(); ++cell) {
      double volume = 0;
      std::memcpy(&volume, tile.cell_columns()[0].values.data() + 8 * cell, sizeof volume);
      if (tile.ghost()[cell] == 0) total += volume;
    }
    ASSERT_EQ(tile.attributes().size(), 1u);
    EXPECT_EQ(tile.attributes()[0].name, "star_volume");
  }
  EXPECT_NEAR(total / report.total, 1, 1e-12);
  EXPECT_FALSE(t.measure(MeasureRequest().volume(true)).made);
  EXPECT_EQ(t.verify().cells(), t.cells());
}

TEST(DensityOf, AResultHasTheMassOfItsPoints) {
  for (const int dimension : {2, 3}) {
    auto t = triangulate(cloud("uniform", dimension, 300), TriangulationOptions().dimension(dimension).tiles(3));
    EXPECT_TRUE(t.measure(MeasureRequest().density(true)).made);
    EXPECT_EQ(t.columns()[0].name, "density");
    const DensityGrid grid = draw_density(t, DensityRequest(0.125).threads(2));
    EXPECT_EQ(grid.size.size(), static_cast<std::size_t>(dimension));
    double sum = 0;
    for (const double value : grid.values) sum += value * std::pow(0.125, dimension);
    EXPECT_EQ(grid.mass, 300);
    EXPECT_NEAR(sum / 300, 1, 1e-12);
    const auto values = draw_density(t, DensityRequest(0.125).field("density").sample(true)).values;
    EXPECT_EQ(values.size(), grid.values.size());
  }
  const auto box = triangulate(cloud("uniform", 3, 100), TriangulationOptions().dimension(3).periodic({1.0}));
  const std::vector<std::int64_t> voxels{4, 5, 3};
  const DensityGrid grid = draw_density(box, DensityRequest(voxels));
  EXPECT_EQ(grid.size, voxels);
  EXPECT_EQ(grid.known, 60U);
  EXPECT_NEAR(grid.grid_mass / 100, 1, 1e-12);
  EXPECT_EQ(density_widths(box, DensityRequest(voxels)), (std::vector<double>{1 / 4., 1 / 5., 1 / 3.}));
  EXPECT_EQ(density_widths(box, DensityRequest(0.5)), std::vector<double>(3, 0.5));
  EXPECT_EQ(failure_of([&] { draw_density(box, DensityRequest(0.3)); }).cause(), Cause::usage);
  const auto t = triangulate(cloud("uniform", 2, 50), TriangulationOptions().dimension(2));
  EXPECT_EQ(failure_of([&] { draw_density(t, DensityRequest(0)); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([&] { DensityRequest(1).bbox(std::vector<double>{1, 2, 3}); }).cause(), Cause::usage);
}

TEST(MeasureOf, NothingIsRefusedInTheWordsOfTheLibrary) {
  auto t = triangulate(cloud("uniform", 2, 50), TriangulationOptions().dimension(2));
  EXPECT_EQ(std::string(failure_of([&] { t.measure({}); }).what()),
            "there is nothing to measure; volume(true) and quality(true) measure cells, voronoi(true) measures the "
            "Voronoi cells of vertices, density(true) the densities of vertices");
}

}  // namespace
}  // namespace tessera

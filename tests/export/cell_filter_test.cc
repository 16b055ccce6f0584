#include "src/result/export/cell_filter.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera::exports {
namespace {

// One cell: the simplex with edges of `scale` along the axes, its corner at `at`.
TileMesh simplex(int dimension, double scale, double at = 0) {
  TileMesh mesh;
  mesh.dimension = dimension;
  mesh.points = {{at, at, at}, {at + scale, at, at}, {at, at + scale, at}, {at, at, at + scale}};
  mesh.cells = {0, 1, 2};
  if (dimension == 3) mesh.cells.push_back(3);
  mesh.cell_ghost = {0};
  return mesh;
}

TEST(CellFilter, LongestEdgesAreRightAtEveryScale) {
  for (const int dimension : {2, 3})
    for (const double scale : {1e-310, 1e-200, 1e-150, 1e-140, 1.0, 1e149, 1e151, 1e200})
      EXPECT_NEAR(longest_edge(simplex(dimension, scale), 0) / scale, std::sqrt(2.0), 1e-9) << scale;
  EXPECT_EQ(longest_edge(simplex(3, -1.7e308, 1.7e308), 0), INFINITY);
}

TEST(CellFilter, HeightsDoNotCountInThePlane) {
  TileMesh mesh = simplex(2, 3);
  mesh.points[1].z = 1000;
  EXPECT_DOUBLE_EQ(longest_edge(mesh, 0), 3 * std::sqrt(2.0));
  mesh = simplex(3, 3);
  mesh.points[3].z = 4;
  EXPECT_EQ(longest_edge(mesh, 0), 5);
}

TEST(CellFilter, ACellAsLongAsTheLimitStaysAndAGhostNever) {
  TileMesh mesh = simplex(3, 3);
  mesh.points[3].z = 4;
  EXPECT_TRUE(CellFilter(CellSizes{.max_edge = 5}).keeps(mesh, 0));
  EXPECT_FALSE(CellFilter(CellSizes{.max_edge = std::nextafter(5, 0)}).keeps(mesh, 0));
  EXPECT_TRUE(CellFilter(CellSizes{}).keeps(mesh, 0));
  mesh.cell_ghost[0] = 1;
  EXPECT_FALSE(CellFilter(CellSizes{}).keeps(mesh, 0));
}

}  // namespace
}  // namespace tessera::exports

// The parts of a cell fill it, whatever the cell and the grid.
#include "src/result/density/shares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "src/base/periodic_box.h"

namespace tessera::density {
namespace {

double volume_of(const std::vector<Point>& p) {
  const auto e = [&](std::size_t k, int axis) -> long double {
    return static_cast<long double>(p[k][axis]) - static_cast<long double>(p[0][axis]);
  };
  if (p.size() == 3) return static_cast<double>(std::abs(e(1, 0) * e(2, 1) - e(1, 1) * e(2, 0)) / 2);
  return static_cast<double>(std::abs(e(1, 0) * (e(2, 1) * e(3, 2) - e(2, 2) * e(3, 1)) -
                                      e(1, 1) * (e(2, 0) * e(3, 2) - e(2, 2) * e(3, 0)) +
                                      e(1, 2) * (e(2, 0) * e(3, 1) - e(2, 1) * e(3, 0))) /
                             6);
}

VoxelGrid grid_of(int dimension, double res, std::int64_t half) {
  VoxelGrid grid{.dimension = dimension};
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension); ++axis) {
    grid.axes[axis].length = res;
    grid.first[axis] = -half;
    grid.size[axis] = 2 * half;
  }
  return grid;
}

// The sum of the parts, divided by the volume of the cell; each voxel comes once.
double filled(const VoxelGrid& grid, const std::vector<Point>& cell) {
  double sum = 0;
  std::set<std::array<std::int64_t, 3>> seen;
  const double voxel = std::pow(grid.axes[0].width(), grid.dimension) / volume_of(cell);
  mean_shares(grid, cell, [&](const CellShare& share) {
    EXPECT_TRUE(seen.insert(share.at).second);
    for (const double weight : share.weights) {
      EXPECT_GT(weight, -1e-14);
      sum += weight * (share.of_voxel ? voxel : 1);
    }
    return true;
  });
  return sum;
}

std::vector<Point> random_cell(std::mt19937_64& random, std::size_t corners, double size) {
  std::vector<Point> cell(corners);
  std::uniform_real_distribution<double> coordinate(-size, size);
  for (Point& p : cell) {
    p.x = coordinate(random);
    p.y = coordinate(random);
    if (corners == 4) p.z = coordinate(random);
  }
  return cell;
}

TEST(MeanShares, FillTheCell) {
  std::mt19937_64 random(1);
  for (const std::size_t corners : {3U, 4U}) {
    for (const double size : {0.1, 1.0, 3.0, 12.0}) {
      for (int trial = 0; trial < (size > 5 ? 10 : 100); ++trial)
        EXPECT_NEAR(filled(grid_of(static_cast<int>(corners) - 1, 0.7, 64), random_cell(random, corners, size)), 1,
                    2e-14);
    }
  }
}

TEST(MeanShares, FillFlatCells) {
  std::mt19937_64 random(2);
  for (const double flat : {1e-3, 1e-9, 1e-15}) {
    for (int trial = 0; trial < 50; ++trial) {
      for (const std::size_t corners : {3U, 4U}) {
        auto cell = random_cell(random, corners, 3);
        // The last corner moves into the plane of the others, but for a little.
        Point mean;
        for (std::size_t k = 0; k + 1 < corners; ++k) {
          mean.x += cell[k].x / static_cast<double>(corners - 1);
          mean.y += cell[k].y / static_cast<double>(corners - 1);
          mean.z += cell[k].z / static_cast<double>(corners - 1);
        }
        for (int axis = 0; axis < 3; ++axis) cell.back()[axis] = mean[axis] + flat * (cell.back()[axis] - mean[axis]);
        if (volume_of(cell) == 0) continue;
        double sum = 0;
        mean_shares(grid_of(static_cast<int>(corners) - 1, 0.7, 64), cell, [&](const CellShare& share) {
          for (const double weight : share.weights) sum += weight;
          return true;
        });
        EXPECT_NEAR(sum, 1, 2e-14);
      }
    }
  }
}

TEST(MeanShares, OfALatticeAreWholeVoxels) {
  // Two triangles of a square with the width of voxels: each is half of one voxel.
  const VoxelGrid grid = grid_of(2, 1, 8);
  int shares = 0;
  mean_shares(grid, std::vector<Point>{{1, 1, 0}, {2, 1, 0}, {2, 2, 0}}, [&](const CellShare& share) {
    EXPECT_EQ(share.at, (std::array<std::int64_t, 3>{1, 1, 0}));
    ++shares;
    return true;
  });
  EXPECT_EQ(shares, 1);
}

TEST(MeanShares, OfAHugeCellAreWholeVoxels) {
  // The grid is a small part of the cell, which reaches 2^35 voxels in each direction.
  for (const std::size_t corners : {3U, 4U}) {
    const double far = 0x1p35;
    std::vector<Point> cell{{-far, -far, corners == 4 ? -far : 0}, {3 * far, 0, 0}, {0, 3 * far, 0}};
    if (corners == 4) cell.push_back({0, 0, 3 * far});
    int whole = 0;
    mean_shares(grid_of(static_cast<int>(corners) - 1, 1, 4), cell, [&](const CellShare& share) {
      EXPECT_TRUE(share.of_voxel);
      double sum = 0;
      for (const double weight : share.weights) sum += weight;
      EXPECT_NEAR(sum, 1, 1e-15);
      ++whole;
      return true;
    });
    EXPECT_EQ(whole, corners == 3 ? 64 : 512);
  }
}

// A period of `count` voxels along each axis.
VoxelGrid periodic_grid(int dimension, double period, std::int64_t count) {
  VoxelGrid grid{.dimension = dimension};
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension); ++axis) {
    grid.axes[axis] = {.origin = 0, .length = period, .count = count, .periodic = true};
    grid.size[axis] = count;
  }
  return grid;
}

TEST(MeanShares, OfAPeriodicGridFillTheCell) {
  std::mt19937_64 random(3);
  for (const std::size_t corners : {3U, 4U}) {
    for (const std::int64_t count : {1, 2, 7, 48}) {
      const VoxelGrid grid = periodic_grid(static_cast<int>(corners) - 1, 5, count);
      for (int trial = 0; trial < 30; ++trial) {
        // From one period before the box to one after it.
        auto cell = random_cell(random, corners, 7.5);
        for (Point& p : cell)
          for (int axis = 0; axis < grid.dimension; ++axis) p[axis] += 2.5;
        const double voxel = std::pow(grid.axes[0].width(), grid.dimension) / volume_of(cell);
        double sum = 0;
        mean_shares(grid, cell, [&](const CellShare& share) {
          for (std::size_t axis = 0; axis < corners - 1; ++axis) {
            EXPECT_GE(share.at[axis], 0);
            EXPECT_LT(share.at[axis], count);
          }
          for (const double weight : share.weights) sum += weight * (share.of_voxel ? voxel : 1);
          return true;
        });
        EXPECT_NEAR(sum, 1, 2e-13);
      }
    }
  }
}

TEST(MeanShares, OfAPartOfAPeriodicGridAreThoseOfTheWhole) {
  std::mt19937_64 random(4);
  const VoxelGrid whole = periodic_grid(2, 5, 10);
  VoxelGrid part = whole;
  part.first = {8, -3, 0};  // over the border
  part.size = {4, 5, 1};
  for (int trial = 0; trial < 50; ++trial) {
    auto cell = random_cell(random, 3, 5);
    std::map<std::array<std::int64_t, 3>, double> wanted, found;
    mean_shares(whole, cell, [&](const CellShare& share) {
      auto at = share.at;
      if (part.find(at)) wanted[at] += share.weights[0] + share.weights[1] + share.weights[2];
      return true;
    });
    mean_shares(part, cell, [&](const CellShare& share) {
      found[share.at] += share.weights[0] + share.weights[1] + share.weights[2];
      return true;
    });
    EXPECT_EQ(found, wanted);
  }
}

TEST(VoxelAxis, HasExactPlanesAtThePeriod) {
  for (const double length : {1.0, in_steps(0.3), in_steps(1e9 / 3), 360.0}) {  // as periods are
    for (const std::int64_t count : {1, 3, 7, 1000, 1 << 24}) {
      const VoxelAxis axis{.origin = 0, .length = length, .count = count, .periodic = true};
      for (const int k : {-1, 0, 1, 2}) {
        const GridPlane plane = axis.plane(k * count);
        EXPECT_EQ(plane.at, k * length);
        EXPECT_EQ(plane.rest, 0);
        EXPECT_EQ(axis.voxel_of(k * length), k * count);
        EXPECT_EQ(axis.voxel_below(k * length), k * count - 1);
      }
      for (const std::int64_t i : {std::int64_t{0}, count / 2, count - 1}) {
        EXPECT_EQ(axis.centre(i + count) - length, axis.centre(i));
        EXPECT_EQ(axis.centre(i - count) + length, axis.centre(i));
        EXPECT_EQ(axis.voxel_of(axis.centre(i)), i);
      }
    }
  }
}

TEST(VoxelAxis, CoversABoxByNumber) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> coordinate(-1e3, 1e3);
  for (int trial = 0; trial < 1000; ++trial) {
    Bounds box;
    for (int i = 0; i < 2; ++i) box.add(Point{coordinate(random), coordinate(random), 0});
    const auto grid = voxels_over("out", 2, {}, {.voxels = {1 + trial % 13, 5}}, box);
    ASSERT_TRUE(grid.has_value());
    EXPECT_EQ(grid.value().size, (std::array<std::int64_t, 3>{1 + trial % 13, 5, 1}));
    EXPECT_EQ(grid.value().first, (std::array<std::int64_t, 3>{}));
    EXPECT_EQ(grid.value().axes[0].plane(0).at, box.lo.x);
    EXPECT_LE(grid.value().axes[0].plane(1 + trial % 13).below(box.hi.x), 0);
  }
}

TEST(VoxelsOver, RefuseWhatDoesNotFitThePeriod) {
  const Bounds all{{0, 0, 0}, {9, 9, 0}};
  const Period period{{10, 3, 0}};
  const auto says = [&](const GridShape& shape) {
    const auto grid = voxels_over("out", 2, period, shape, all);
    return grid ? std::string() : grid.error().where;
  };
  EXPECT_EQ(says({.res = 0.1}), "");
  EXPECT_EQ(says({.res = 1.0 / 3}), "");
  EXPECT_EQ(says({.res = 0.333333333333}), "");
  EXPECT_NE(says({.res = 0.3})
                .find("does not divide the period 10 along x; the next widths that do are 0.303030303030303 "
                      "and 0.294117647058824"),
            std::string::npos);
  EXPECT_NE(says({.res = 5}).find("does not divide the period 3 along y; the next widths that do are 3 and 1.5"),
            std::string::npos);
  EXPECT_NE(says({.res = 1e-9}).find("is too small"), std::string::npos);
  EXPECT_EQ(says({.voxels = {7}}), "");
  EXPECT_EQ(says({.voxels = {7, 1}}), "");
  EXPECT_NE(says({.voxels = {7, 1, 2}}).find("takes 1, or one for each of the 2 axes"), std::string::npos);
  EXPECT_NE(says({.voxels = {0}}).find("must be 1 to 16777216"), std::string::npos);
  EXPECT_NE(says({.res = 1, .voxels = {7}}).find("give one of them"), std::string::npos);
  EXPECT_EQ(says({.res = 1, .box = Bounds{{-5, 1, 0}, {5, 2, 0}}}), "");
  EXPECT_NE(says({.res = 1, .box = Bounds{{-5, 1, 0}, {5.5, 2, 0}}}).find("longer than the period along x, 10"),
            std::string::npos);
  EXPECT_NE(says({.voxels = {7}, .box = Bounds{{-5, 1, 0}, {5, 2, 0}}}).find("counts the pixels of the whole period"),
            std::string::npos);
}

TEST(SampleShares, GiveEachCentreToOneCell) {
  // A cube of six tetrahedra around a diagonal; its centres are on the edges and facets of cells.
  const std::vector<Point> cube{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}, {0, 0, 4}, {4, 0, 4}, {0, 4, 4}, {4, 4, 4}};
  const std::size_t paths[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  VoxelGrid grid = grid_of(3, 1, 8);
  std::multiset<std::array<std::int64_t, 3>> seen;
  for (const auto& path : paths) {
    const std::vector<Point> cell{cube[path[0]], cube[path[1]], cube[path[2]], cube[path[3]]};
    const std::vector<std::uint8_t> oriented{0, 1, 2, 3};
    sample_shares(grid, cell, oriented, [&](const CellShare& share) {
      seen.insert(share.at);
      for (int axis = 0; axis < 3; ++axis) {
        double at = 0;
        for (std::size_t k = 0; k < 4; ++k) at += share.weights[k] * cell[k][axis];
        EXPECT_NEAR(at, grid.axes[static_cast<std::size_t>(axis)].centre(share.at[static_cast<std::size_t>(axis)]),
                    1e-14);
      }
      return true;
    });
  }
  EXPECT_EQ(seen.size(), 64U);
  EXPECT_EQ(std::set(seen.begin(), seen.end()).size(), 64U);
}

}  // namespace
}  // namespace tessera::density

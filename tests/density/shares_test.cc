// The parts of a cell fill it, whatever the cell and the grid.
#include "src/result/density/shares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <span>
#include <vector>

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
  VoxelGrid grid{.dimension = dimension, .res = res};
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension); ++axis) {
    grid.first[axis] = -half;
    grid.size[axis] = 2 * half;
  }
  return grid;
}

// The sum of the parts, divided by the volume of the cell; each voxel comes once.
double filled(const VoxelGrid& grid, const std::vector<Point>& cell) {
  double sum = 0;
  std::set<std::array<std::int64_t, 3>> seen;
  const double voxel = std::pow(grid.res, grid.dimension) / volume_of(cell);
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
        EXPECT_NEAR(at, grid.centre(share.at[static_cast<std::size_t>(axis)]), 1e-14);
      }
      return true;
    });
  }
  EXPECT_EQ(seen.size(), 64U);
  EXPECT_EQ(std::set(seen.begin(), seen.end()).size(), 64U);
}

}  // namespace
}  // namespace tessera::density

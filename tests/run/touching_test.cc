#include "src/delaunay/run/touching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/tiling/partition.h"

namespace tessera {
namespace {

constexpr double side = 8;

struct CutSquare {
  Partition partition;
  std::vector<Bounds> bounds;
};

// A lattice of points in a square or cube of 0 to `side`, cut into about `tiles` equal boxes.
CutSquare cut_lattice(int dimension, std::uint32_t tiles) {
  std::vector<Point> points;
  Bounds all;
  for (double x = 0; x < side; ++x) {
    for (double y = 0; y < side; ++y) {
      for (double z = 0; z < (dimension == 3 ? side : 1); ++z) points.push_back({x, y, z});
    }
  }
  for (const Point& p : points) all.add(p);
  CutSquare out{Partition::build_tiles(PartitionKind::grid, dimension, points, all, tiles), {}};
  out.bounds.resize(out.partition.tiles());
  for (const Point& p : points) out.bounds[out.partition.tile_of(p).value].add(p);
  return out;
}

bool touch(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a.lo[axis] > b.hi[axis] || b.lo[axis] > a.hi[axis]) return false;
  }
  return true;
}

TEST(Touching, InAPeriodicCloudAreAllImagesThatTouch) {
  for (const int dimension : {2, 3}) {
    for (const std::uint32_t tiles : {1, 2, 9, 30}) {
      for (const Period& period : {Period{}, Period{{side, 0, 0}}, Period{{side, side, 0}}}) {
        const CutSquare square = cut_lattice(dimension, tiles);
        const auto shared = std::make_shared<const Partition>(square.partition);
        const auto boxes = final_boxes(shared, period);
        const auto found = touching_tiles(square.partition, square.bounds, period);
        for (std::uint32_t a = 0; a < square.partition.tiles(); ++a) {
          std::vector<TileId> expected;
          for (std::uint32_t b = 0; b < square.partition.tiles(); ++b) {
            for (const PeriodOffset& o : period.offsets()) {
              const TileId there = image_of(TileId{b}, o);
              const Box box{period.shifted((*boxes)[b].lo, o), period.shifted((*boxes)[b].hi, o)};
              if (there != TileId{a} && touch((*boxes)[a], box)) expected.push_back(there);
            }
          }
          std::sort(expected.begin(), expected.end());
          EXPECT_EQ(found[a], expected);
        }
      }
    }
  }
}

// A cell that leaves the periodic box is not final, however far its tile reaches.
TEST(Touching, BoxesOfFinalCellsEndAtThePeriod) {
  const auto partition = std::make_shared<const Partition>(cut_lattice(2, 1).partition);
  EXPECT_EQ(final_boxes(partition)->at(0), Box{});
  const Box cut = final_boxes(partition, {{side, 0, 0}})->at(0);
  EXPECT_EQ(cut.lo.x, 0);
  EXPECT_EQ(cut.hi.x, side);
  EXPECT_EQ(cut.hi.y, Box{}.hi.y);
}

}  // namespace
}  // namespace tessera

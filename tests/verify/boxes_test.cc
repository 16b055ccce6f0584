#include "src/result/verify/boxes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "src/tiling/partition.h"
#include "tests/verify/verify_testing.h"

namespace tessera {
namespace {

struct Kind {
  PartitionKind kind;
  int dimension;
};

class Boxes : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Boxes,
                         testing::Values(Kind{PartitionKind::kdtree, 2}, Kind{PartitionKind::kdtree, 3},
                                         Kind{PartitionKind::grid, 2}, Kind{PartitionKind::grid, 3},
                                         Kind{PartitionKind::octree, 2}, Kind{PartitionKind::octree, 3}),
                         [](const auto& info) {
                           return name_of(info.param.kind) + std::to_string(info.param.dimension);
                         });

Manifest manifest_of(const Partition& partition) {
  Manifest manifest;
  manifest.partition = partition.to_json();
  manifest.partition_kind = name_of(partition.kind());
  manifest.boxes = partition.boxes();
  manifest.tiles.resize(1);
  manifest.tiles[0].tile = TileId{partition.tiles() - 1};
  return manifest;
}

TEST_P(Boxes, OfAPartitionPartSpaceAndWithAnyPlaneMovedTheyDoNot) {
  const auto points = test::sample_points(test::Shape::terrain, GetParam().dimension, 500);
  Bounds bounds;
  for (const auto& p : points) bounds.add(p);
  const auto partition = Partition::build_tiles(GetParam().kind, GetParam().dimension, points, bounds, 60);
  const Manifest good = manifest_of(partition);
  EXPECT_GE(good.boxes.size(), 60u);
  EXPECT_TRUE(check_boxes(good, "out"));
  int moved = 0;
  for (std::size_t tile = 0; tile < good.boxes.size(); ++tile)
    for (int axis = 0; axis < 3; ++axis)
      for (const bool lower : {true, false})
        for (const double towards : {-1e9, 1e9}) {
          Manifest bad = good;
          double& plane = (lower ? bad.boxes[tile].lo : bad.boxes[tile].hi)[axis];
          plane = std::nextafter(plane, towards);
          const auto result = check_boxes(bad, "out");
          ASSERT_FALSE(result) << tile << " " << axis << " " << lower << " " << towards;
          EXPECT_EQ(result.error().code, Errc::corrupt);
          ++moved;
        }
  EXPECT_GE(moved, 60 * 12);
}

TEST(Boxes, TwoThatChangePlacesStillPartSpaceButAreNotThePartitions) {
  Manifest manifest;
  manifest.partition = R"({"kind": "kdtree", "dimension": 3, "tiles": 2, "splits": [[0, 0.5, -1, -2]]})";
  manifest.boxes.resize(2);
  manifest.boxes[0].hi.x = manifest.boxes[1].lo.x = 0.5;
  EXPECT_TRUE(check_boxes(manifest, "out"));
  std::swap(manifest.boxes[0], manifest.boxes[1]);
  EXPECT_FALSE(check_boxes(manifest, "out"));
}

}  // namespace
}  // namespace tessera

// Removing vertices leaves the triangulation without them.
#include <gtest/gtest.h>

#include <vector>

#include "tests/kernel/kernel_testing.h"

namespace tessera::testing {
namespace {

class Removal : public ::testing::TestWithParam<KernelCloud> {};

// The reference for those that are alive, with the ids of the kernel's vertices.
std::vector<IdCell> reference_of_alive(const Kernel& kernel, const KernelCloud& cloud) {
  std::vector<LocalPoint> alive;
  for (Vertex v = 1; v <= kernel.vertices(); ++v) {
    if (kernel.alive(v)) alive.push_back({kernel.point(v), v - 1});
  }
  return global_delaunay_with_hull(alive, cloud.dimension);
}

TEST_P(Removal, LeavesTheTriangulationOfTheOthers) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  std::size_t removed = 0;
  for (const std::size_t i : shuffled(cloud.points.size(), 6)) {
    if (removed > cloud.points.size() / 2) break;
    const Vertex v = static_cast<Vertex>(i + 1);
    kernel->remove(v);
    EXPECT_FALSE(kernel->alive(v));
    if (++removed % 5 != 1) continue;
    const auto expected = reference_of_alive(*kernel, cloud);
    ASSERT_EQ(kernel->dimension() == cloud.dimension, !expected.empty());
    if (expected.empty()) break;
    ASSERT_EQ(difference(expected, cells_of(*kernel)), "") << removed << " removed, last vertex " << v;
    ASSERT_EQ(wrong_with(*kernel), "");
  }
  EXPECT_EQ(kernel->vertices(), cloud.points.size());  // numbers are not given again
}

TEST_P(Removal, AndInsertionAgainRestoresTheTriangulationUnderNewNumbers) {
  const KernelCloud& cloud = GetParam();
  const auto kernel = built(cloud);
  std::vector<PointId> ids;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) ids.push_back({i});
  std::vector<Vertex> around;
  for (std::size_t i = 0; i < cloud.points.size(); i += 3) kernel->remove(static_cast<Vertex>(i + 1));
  for (std::size_t i = 0; i < cloud.points.size(); i += 3) {
    const Insertion made = kernel->insert(cloud.points[i], true, InsertMode::always, around);
    ASSERT_TRUE(made.inserted);
    ids.push_back({i});
    ASSERT_EQ(made.vertex, ids.size());
  }
  EXPECT_EQ(difference(reference(cloud.points, cloud.dimension), cells_of(*kernel, ids)), "");
}

INSTANTIATE_TEST_SUITE_P(Kernel, Removal, ::testing::ValuesIn(spanning_clouds()),
                         [](const auto& info) { return name_of_cloud(info.param); });

}  // namespace
}  // namespace tessera::testing

// Saving and loading.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/kernel/kernel_testing.h"

namespace tessera::testing {
namespace {

class Image : public ::testing::TestWithParam<KernelCloud> {};

std::vector<KernelCloud> all_clouds() {
  auto clouds = spanning_clouds();
  clouds.insert(clouds.end(), flat_clouds().begin(), flat_clouds().end());
  return clouds;
}

TEST_P(Image, LoadsAsWhatWasSavedAndGoesOnAlike) {
  const KernelCloud& cloud = GetParam();
  // Some vertices foreign, some removed, some still to come.
  const std::size_t first = cloud.points.size() * 3 / 4;
  const auto kernel = make_kernel(cloud.dimension, cloud.kind);
  std::vector<Vertex> around, around_copy;
  for (std::size_t i = 0; i < first; ++i) kernel->insert(cloud.points[i], i % 3 != 0, InsertMode::always, around);
  for (Vertex v = 2; v <= kernel->vertices() && kernel->vertices() > 20; v += 9) kernel->remove(v);

  const auto copy = make_kernel(cloud.dimension, cloud.kind);
  copy->build(std::vector<Point>{{7, 7, 0}, {8, 9, 0}});  // is replaced
  ASSERT_TRUE(copy->load(kernel->save()));
  const auto expect_equal = [&] {
    ASSERT_EQ(copy->vertices(), kernel->vertices());
    EXPECT_EQ(copy->dimension(), kernel->dimension());
    for (Vertex v = 1; v <= kernel->vertices(); ++v) {
      ASSERT_EQ(copy->alive(v), kernel->alive(v));
      EXPECT_EQ(copy->is_local(v), kernel->is_local(v));
      if (kernel->alive(v)) {
        EXPECT_EQ(copy->point(v), kernel->point(v));
      }
    }
    if (kernel->dimension() < cloud.dimension) return;
    EXPECT_EQ(difference(cells_of(*kernel), cells_of(*copy)), "");
    EXPECT_EQ(wrong_with(*copy), "");
  };
  expect_equal();
  for (std::size_t i = first; i < cloud.points.size(); ++i) {
    const auto mode = i % 2 == 0 ? InsertMode::always : InsertMode::if_local_neighbour;
    const Insertion made = kernel->insert(cloud.points[i], false, mode, around);
    const Insertion again = copy->insert(cloud.points[i], false, mode, around_copy);
    EXPECT_EQ(made.vertex, again.vertex);
    EXPECT_EQ(made.inserted, again.inserted);
    std::sort(around.begin(), around.end());
    std::sort(around_copy.begin(), around_copy.end());
    EXPECT_EQ(around, around_copy);
  }
  for (Vertex v = 5; v <= kernel->vertices() && kernel->vertices() > 20; v += 10) {
    if (!kernel->alive(v)) continue;
    kernel->remove(v);
    copy->remove(v);
  }
  expect_equal();
}

TEST_P(Image, IsRefusedWhenDamaged) {
  const KernelCloud& cloud = GetParam();
  const KernelImage good = built(cloud)->save();
  const auto kernel = make_kernel(cloud.dimension, cloud.kind);
  const auto refused = [&](auto&& damage) {
    KernelImage bad = good;
    damage(bad);
    return !kernel->load(bad);
  };
  EXPECT_TRUE(refused([](auto& i) { i.local.push_back(1); }));
  EXPECT_TRUE(refused([](auto& i) { i.alive.push_back(1); }));
  EXPECT_TRUE(refused([](auto& i) { i.points.push_back({1e3, 1e3, 1e3}); }));
  EXPECT_TRUE(refused([](auto& i) { i.cells.vertices.push_back(0); }));
  EXPECT_TRUE(refused([](auto& i) { i.cells.neighbors.push_back(0); }));
  EXPECT_TRUE(refused([](auto& i) { i.dimension = -2; }));
  EXPECT_TRUE(refused([&](auto& i) { i.dimension = cloud.dimension + 1; }));
  if (good.cells.vertices.empty()) return;
  EXPECT_TRUE(refused([](auto& i) { i.dimension -= 1; }));
  EXPECT_TRUE(refused([](auto& i) { i.alive[0] = 0; }));
  EXPECT_TRUE(refused([](auto& i) { i.cells.vertices.clear(); }));
  EXPECT_TRUE(refused([](auto& i) { i.cells = {}; }));
  EXPECT_TRUE(refused([](auto& i) { i.cells.vertices.pop_back(); }));
  EXPECT_TRUE(refused([](auto& i) { i.cells.neighbors.pop_back(); }));
  for (const Vertex v : {static_cast<Vertex>(good.points.size() + 1), ~Vertex{0}}) {
    EXPECT_TRUE(refused([&](auto& i) { i.cells.vertices.back() = v; }));
  }
  const auto cells = static_cast<std::uint32_t>(good.cells.neighbors.size() / (cloud.dimension + 1));
  for (const std::uint32_t c : {cells, ~std::uint32_t{0}}) {
    EXPECT_TRUE(refused([&](auto& i) { i.cells.neighbors.front() = c; }));
  }
  if (cloud.kind == KernelKind::flat) {
    EXPECT_TRUE(refused([](auto& i) {  // a cell that is turned inside out
      std::swap(i.cells.vertices[0], i.cells.vertices[1]);
      std::swap(i.cells.neighbors[0], i.cells.neighbors[1]);
    }));
    EXPECT_TRUE(refused([](auto& i) { std::swap(i.cells.neighbors[0], i.cells.neighbors[1]); }));
    EXPECT_TRUE(refused([](auto& i) { i.cells.neighbors[0] = across_frozen; }));
  }
  EXPECT_TRUE(kernel->load(good));
  EXPECT_EQ(cells_of(*kernel), cells_of(*built(cloud)));
}

INSTANTIATE_TEST_SUITE_P(Kernel, Image, ::testing::ValuesIn(all_clouds()),
                         [](const auto& info) { return name_of_cloud(info.param); });

}  // namespace
}  // namespace tessera::testing

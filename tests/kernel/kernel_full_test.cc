// A tile too large for the flat kernel's indices, made small by a limit: an error that can be told, not a wrong cell.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "src/geometry/kernel/flat/flat_kernel.h"
#include "src/geometry/reference/clouds.h"
#include "tests/kernel/kernel_testing.h"

namespace tessera::testing {
namespace {

class Full : public ::testing::TestWithParam<int> {
 protected:
  Full() {
    for (const LocalPoint& p : make_cloud("uniform", dimension_, 300, 5)) points_.push_back(p.at);
    cells_ = static_cast<std::uint32_t>(cells_of(*kernel_with({}, points_)).size());
  }
  std::unique_ptr<Kernel> kernel_with(const FlatOptions& options, const std::vector<Point>& points) const {
    auto kernel = dimension_ == 2 ? make_flat_kernel_2(options) : make_flat_kernel_3(options);
    kernel->build(points);
    return kernel;
  }
  // The first n points.
  std::vector<Point> first(std::size_t n) const { return {points_.begin(), points_.begin() + std::ptrdiff_t(n)}; }
  void insert_all(Kernel& kernel) const {
    std::vector<Vertex> around;
    for (const Point& p : points_) kernel.insert(p, false, InsertMode::always, around);
  }

  int dimension_ = GetParam();
  std::vector<Point> points_;
  std::uint32_t cells_ = 0;
};

TEST_P(Full, AsManyVerticesAsCanBeNumberedAreTaken) {
  EXPECT_EQ(cells_of(*kernel_with({.vertices_max = 300}, points_)).size(), cells_);
  const auto kernel = kernel_with({.vertices_max = 300}, first(100));
  insert_all(*kernel);
  EXPECT_EQ(difference(reference(points_, dimension_), cells_of(*kernel)), "");
}

TEST_P(Full, OneVertexMoreIsAnError) {
  EXPECT_THROW(kernel_with({.vertices_max = 299}, points_), KernelFull);
  EXPECT_THROW(insert_all(*kernel_with({.vertices_max = 299}, first(100))), KernelFull);
  EXPECT_THROW(insert_all(*kernel_with({.vertices_max = 1}, {})), KernelFull);
}

TEST_P(Full, MoreCellsThanCanBeNumberedAreAnError) {
  EXPECT_THROW(kernel_with({.cells_max = cells_ / 2}, points_), KernelFull);
  EXPECT_THROW(insert_all(*kernel_with({.cells_max = cells_ / 2}, first(20))), KernelFull);
  EXPECT_THROW(kernel_with({.vectors = false, .cells_max = cells_ - 1}, points_), KernelFull);
}

TEST_P(Full, AnImageThatIsTooLargeIsRefused) {
  const KernelImage image = kernel_with({}, points_)->save();
  EXPECT_TRUE(kernel_with({.vertices_max = 300, .cells_max = cells_}, {})->load(image));
  EXPECT_FALSE(kernel_with({.vertices_max = 299}, {})->load(image));
  EXPECT_FALSE(kernel_with({.cells_max = cells_ - 1}, {})->load(image));
}

TEST_P(Full, AFullKernelCanBeBuiltAgain) {
  const std::vector<Point> fewer = first(60);
  const auto expected = reference(fewer, dimension_);
  for (const FlatOptions& options : {FlatOptions{.cells_max = cells_ / 2}, FlatOptions{.vertices_max = 299}}) {
    const auto kernel = kernel_with(options, first(20));
    EXPECT_THROW(insert_all(*kernel), KernelFull);
    kernel->build(fewer);
    EXPECT_EQ(difference(expected, cells_of(*kernel)), "");
    EXPECT_EQ(wrong_with(*kernel), "");
    EXPECT_THROW(insert_all(*kernel), KernelFull);
    EXPECT_TRUE(kernel->load(kernel_with({}, fewer)->save()));
    EXPECT_EQ(difference(expected, cells_of(*kernel)), "");
  }
}

INSTANTIATE_TEST_SUITE_P(Dimensions, Full, ::testing::Values(2, 3),
                         [](const auto& info) { return "in" + std::to_string(info.param) + "D"; });

}  // namespace
}  // namespace tessera::testing

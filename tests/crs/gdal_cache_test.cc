#include "src/base/crs/gdal_cache.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace tessera {
namespace {

TEST(GdalCacheShare, AddsUpAndLeavesWhatWasThereBefore) {
  const auto gdal = gdal_library();
  ASSERT_TRUE(gdal) << gdal.error().where;
  const auto size = [&] { return gdal.value()->GDALGetCacheMax64(); };
  gdal.value()->GDALSetCacheMax64(50'000'000);
  auto first = std::make_unique<GdalCacheShare>(*gdal.value(), 10'000'000);
  EXPECT_EQ(size(), 10'000'000);
  auto second = std::make_unique<GdalCacheShare>(*gdal.value(), 7'000'000);
  EXPECT_EQ(size(), 17'000'000);
  first.reset();  // in another order than they came
  EXPECT_EQ(size(), 7'000'000);
  second.reset();
  EXPECT_EQ(size(), 50'000'000);
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 200; ++k) const GdalCacheShare share(*gdal.value(), 1'000'000);
    });
  threads.clear();
  EXPECT_EQ(size(), 50'000'000);
}

}  // namespace
}  // namespace tessera

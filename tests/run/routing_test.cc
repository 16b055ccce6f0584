#include "src/delaunay/run/routing.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "src/base/files/temporary.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

// A node reads the columns that the coordinator was asked for.
TEST(Routing, NodesReadColumnsByTheirNames) {
  const TemporaryFolder made = TemporaryFolder::make().value();
  const fs::path& folder = made.path();
  {
    std::ofstream out(folder / "in.csv");
    for (int i = 0; i < 100; ++i) out << "P" << i << "," << i % 7 << "," << 1000 + i << "," << -i << ",word\n";
  }
  const auto cloud = Cloud::open({(folder / "in.csv").string()}, {.columns = {"_", "y", "x", "z"}});
  ASSERT_TRUE(cloud) << cloud.error().where;
  Partition partition;
  ASSERT_TRUE(write_routing(folder, cloud.value(), {cloud.value().whole()}, partition));
  const SplitWork work{folder, 1, 1 << 20};
  fs::create_directory(folder / "points");
  fs::create_directory(folder / "stretches");
  const Status routed = route_split(folder, 0, 1, work, {});
  ASSERT_TRUE(routed) << routed.error().where;
  const auto found = read_split(folder, 1, partition);
  ASSERT_TRUE(found) << found.error().where;
  EXPECT_EQ(found.value().counts.read, 100u);
  EXPECT_EQ(found.value().bounds[0].lo, (Point{1000, 0, -99}));
  EXPECT_EQ(found.value().bounds[0].hi, (Point{1099, 6, 0}));
}

}  // namespace
}  // namespace tessera

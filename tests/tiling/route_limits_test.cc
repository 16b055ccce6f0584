// Routing with little: descriptors, memory, disk.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>

#include "src/base/files/names.h"
#include "tests/tiling/run_fixture.h"

namespace tessera {
namespace {

using RouteWithLittle = RunFixture;

// Runs `body` in a child with a resource limit, which a process cannot raise again. True if body returned true.
bool in_child_with_limit(int resource, rlim_t limit, const std::function<bool()>& body) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit value{limit, limit};
    const bool ok = ::setrlimit(static_cast<__rlimit_resource>(resource), &value) == 0 && body();
    ::_exit(ok ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST_F(RouteWithLittle, NeedsFewOpenFilesHoweverManyTiles) {
  const auto points = make_cloud("uniform", 3, 20000);
  const auto path = write_npy(points, 3);
  EXPECT_TRUE(in_child_with_limit(RLIMIT_NOFILE, 64, [&] {
    const auto run = route(open_cloud(path, 3), run_folder(), {.tiles = 700}, progress_, {});
    return run.has_value() && open_run(run_folder()).has_value();
  }));
  const auto run = open_run(run_folder());
  ASSERT_TRUE(run) << run.error().where;
  EXPECT_EQ(run.value().partition.tiles(), 700u);
  expect_complete(run.value(), points);
}

TEST_F(RouteWithLittle, TellsWhichFileCouldNotBeWrittenAndLeavesNothing) {
  const auto path = write_npy(make_cloud("uniform", 3, 20000), 3);
  // A tile of 10000 points needs 320000 bytes; the limit fails the write as a full disk would.
  EXPECT_TRUE(in_child_with_limit(RLIMIT_FSIZE, 100000, [&] {
    const auto run = route(open_cloud(path, 3), run_folder(), {.tiles = 2}, progress_, {});
    return !run && run.error().code == Errc::io &&
           run.error().where == (run_folder() / "points/000000-000000.bin").string() + ": cannot write: File too large";
  }));
  EXPECT_FALSE(std::filesystem::exists(run_folder() / "points"));
  EXPECT_FALSE(std::filesystem::exists(run_folder() / "plan.json"));
}

TEST_F(RouteWithLittle, TellsWhenItsFolderCannotBeMade) {
  const auto cloud = open_cloud(write_npy(make_cloud("uniform", 3, 100), 3), 3);
  write_text(folder_ / "file", "");
  const auto run = route(cloud, folder_ / "file" / "run", {.tiles = 2}, progress_, {});
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, Errc::io);
  EXPECT_NE(run.error().where.find((folder_ / "file").string()), std::string::npos);
}

TEST_F(RouteWithLittle, GivesTheSameTilesWithLittleMemoryAsWithMuch) {
  const auto cloud = open_cloud(write_npy(make_cloud("lattice", 3, 50000), 3), 3);
  RouteOptions options{.kind = PartitionKind::random, .tiles = 13};
  const auto much = route(cloud, folder_ / "much", options, progress_, {});
  options.memory_bytes = 1 << 16;
  const auto little = route(cloud, folder_ / "little", options, progress_, {});
  ASSERT_TRUE(much && little);
  EXPECT_EQ(much.value().bundles.size(), 1u);
  EXPECT_GT(little.value().bundles.size(), 10u);
  for (std::uint32_t t = 0; t < 13; ++t) EXPECT_EQ(read_points(much.value(), t), read_points(little.value(), t));
  EXPECT_EQ(much.value().seeds, little.value().seeds);
}

// A grid over two clusters leaves everything in two boxes, and the memory holds a thirteenth of them.
TEST_F(RouteWithLittle, SplitsTilesThatDoNotFitItsMemory) {
  const auto points = make_cloud("clusters", 3, 100000);
  const auto run =
      route_points(points, 3, {.kind = PartitionKind::grid, .max_points_per_tile = 3000, .memory_bytes = 1 << 16});
  ASSERT_TRUE(run) << run.error().where;
  expect_complete(run.value(), points);
  for (const std::uint64_t n : run.value().tile_points) EXPECT_LE(n, 3000u);
  EXPECT_TRUE(open_run(run_folder()));
}

// The sample of the full tile is one place only: the few other points must still be found.
TEST_F(RouteWithLittle, SplitsOffTheFewPointsThatAreNotEqual) {
  auto points = make_cloud("identical", 3, 60000);
  for (std::size_t i = 0; i < 5; ++i) points[10007 * (i + 1)] = {0.1 * static_cast<double>(i), -7, double(i * i)};
  const auto run =
      route_points(points, 3, {.kind = PartitionKind::grid, .max_points_per_tile = 1000, .memory_bytes = 1 << 16});
  ASSERT_TRUE(run) << run.error().where;
  expect_complete(run.value(), points);
  for (std::uint32_t t = 0; t < run.value().partition.tiles(); ++t) {
    if (run.value().tile_points[t] <= 1000) continue;
    EXPECT_EQ(load_tile(run.value(), TileId{t}).value().points.size(), 1u);
  }
}

// A grid's box has nearly all points, and is split again and again.
TEST_F(RouteWithLittle, GivesTheDiskOfRecordsBackThatAreWrittenAnew) {
  auto points = make_cloud("uniform", 3, 50'000);
  for (std::size_t i = 10; i < points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) points[i][axis] /= 1000;
  const auto run = route_points(points, 3, {.kind = PartitionKind::grid, .max_points_per_tile = 5000});
  ASSERT_TRUE(run) << run.error().where;
  expect_complete(run.value(), points);
  std::uint64_t written = 0, held = 0;
  for (const auto& file : std::filesystem::directory_iterator(points_folder(run_folder()))) {
    struct stat status {};
    ASSERT_EQ(::stat(file.path().c_str(), &status), 0);
    written += static_cast<std::uint64_t>(status.st_size);
    held += static_cast<std::uint64_t>(status.st_blocks) * 512;
  }
  const std::uint64_t needed = points.size() * sizeof(LocalPoint);
  EXPECT_GT(written, needed + needed / 2);
  EXPECT_LT(held, needed + needed / 4);
}

}  // namespace
}  // namespace tessera

// Several runs on one engine, after one another and at once.
#include "actors/engine/engine.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/geometry/reference/clouds.h"
#include "src/input/npy/array_source.h"

namespace tessera {
namespace {

class Runs : public ::testing::Test {
 protected:
  // A routed cloud in 5 tiles whose result goes to the folder `name`.
  RoutedCloud routed(const std::string& name, std::size_t points = 300) {
    const auto coordinates = coordinates_of(make_cloud("uniform", 3, points, 1), 3);
    const auto out = folder_.path() / name;
    std::filesystem::create_directory(out);
    Progress progress;
    const Cloud cloud = Cloud::open_source(array_source("cloud", coordinates, 3), {.dimension = 3}).value();
    return route(cloud, run_folder(out), {.tiles = 5}, progress, {}).value();
  }

  // The number of cells, or the sentence of a failure.
  static std::string run(Engine& engine, const RoutedCloud& run, const RunOptions& options) {
    Progress progress;
    const auto summary = engine.run(run, run.folder.parent_path(), options, progress, {});
    return summary ? std::to_string(summary.value().cells) : summary.error().where;
  }

  std::string cells_of_one() {
    Engine engine(2, memory);
    return run(engine, routed("one"), {.threads = 2, .memory_bytes = memory});
  }

  static constexpr std::uint64_t memory = std::uint64_t{256} << 20;

 private:
  TemporaryFolder folder_ = TemporaryFolder::make().value();
};

TEST_F(Runs, InARowEachHaveTheWholeMemory) {
  const std::string cells = cells_of_one();
  const RoutedCloud again = routed("again");
  Engine engine(2, memory);
  // All but the first find every tile stored: they end as soon as they have begun.
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(run(engine, again, {.threads = 2, .memory_bytes = memory}), cells) << i;
}

// Each works in its share of the memory, and in turn on the engine's threads.
TEST_F(Runs, AtOnceShareMemoryAndThreads) {
  const std::string cells = cells_of_one();
  constexpr int runs = 4;
  std::vector<RoutedCloud> clouds;
  for (int i = 0; i < runs; ++i) clouds.push_back(routed(std::to_string(i)));
  Engine engine(2, memory);
  std::vector<std::string> got(runs);
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < runs; ++i)
      threads.emplace_back([&, i] { got[i] = run(engine, clouds[i], {.threads = 2, .memory_bytes = memory / runs}); });
  }
  EXPECT_EQ(got, std::vector<std::string>(runs, cells));
}

// What is found damaged where no tile tells another anything any more is built again, from its points.
TEST_F(Runs, ThatWereSettledGoOnWithoutAnExchangeOrMendWhatIsDamaged) {
  const std::string cells = cells_of_one();
  for (const std::string damage : {"none", "cut", "flipped"}) {
    const bool damaged = damage != "none";
    const RoutedCloud cloud = routed(damage);
    const auto tiles = tiles_folder(cloud.folder.parent_path());
    for (std::uint32_t t = 0; t < cloud.tile_points.size(); ++t)  // in the way of each
      std::filesystem::create_directories(tile_file(cloud.folder.parent_path(), TileId{t}) / "somebody's");
    Engine engine(2, memory);
    EXPECT_NE(run(engine, cloud, {.memory_bytes = memory}).find(tiles.string()), std::string::npos);
    EXPECT_TRUE(std::filesystem::exists(settled_marker(cloud.folder)));
    std::filesystem::remove_all(tiles);
    const auto foreign = settled_file(cloud.folder, NodeId{0});
    if (damage == "cut") std::filesystem::resize_file(foreign, std::filesystem::file_size(foreign) - 1);
    if (damage == "flipped") {
      auto bytes = read_whole(foreign).value();
      bytes[bytes.size() / 2] ^= std::byte{1};
      ASSERT_TRUE(write_whole(foreign, bytes));
    }
    Progress progress;
    const auto resumed = engine.run(cloud, cloud.folder.parent_path(), {.memory_bytes = memory}, progress, {});
    ASSERT_TRUE(resumed) << resumed.error().where;
    EXPECT_EQ(std::to_string(resumed.value().cells), cells);
    EXPECT_EQ(resumed.value().exchange.waves > 0, damaged);
  }
}

// The run is stopped in each phase, and goes on to the next one. A tile that was stopped at its work begins from what
// it began from before.
TEST_F(Runs, ThatAreStoppedInEveryPhaseGoOnToTheSameResult) {
  Engine engine(2, memory);
  const RoutedCloud whole = routed("whole", 40'000);
  Progress unwatched;
  const auto expected =
      engine.run(whole, whole.folder.parent_path(), {.threads = 2, .memory_bytes = memory}, unwatched, {});
  ASSERT_TRUE(expected) << expected.error().where;
  const auto sum = [](const RunSummary& summary) {
    Digest digest;
    for (const TileEntry& tile : summary.tiles) digest += tile.digest.value();
    return digest;
  };
  int interrupted = 0;
  for (const std::uint64_t bytes : {memory, std::uint64_t{1}}) {  // all in memory; every tile sleeps when it may
    const RoutedCloud cloud = routed("stopped " + std::to_string(bytes), 40'000);
    const RunOptions how{.threads = 2, .memory_bytes = bytes};
    for (const Phase phase : {Phase::planning, Phase::triangulating, Phase::splaying, Phase::collecting, Phase::done}) {
      Progress progress;
      std::stop_source stop;
      if (phase == Phase::planning) stop.request_stop();
      std::jthread watcher([&](const std::stop_token& over) {
        while (!over.stop_requested() && progress.phase < phase)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (!over.stop_requested()) stop.request_stop();
      });
      const auto ended = engine.run(cloud, cloud.folder.parent_path(), how, progress, stop.get_token());
      watcher.request_stop();
      if (ended) {  // later phases were as quick as the watcher
        EXPECT_EQ(sum(ended.value()), sum(expected.value()));
        EXPECT_EQ(ended.value().tiles.size(), expected.value().tiles.size());
        break;
      }
      ASSERT_EQ(ended.error().code, Errc::interrupted) << ended.error().where;
      ++interrupted;
    }
  }
  EXPECT_GE(interrupted, 2) << "one that is stopped before it begins does not end well";
}

TEST_F(Runs, ThatWantMoreThanTheEngineHasAreRefused) {
  Engine engine(2, memory);
  EXPECT_EQ(run(engine, routed("large"), {.memory_bytes = 2 * memory}),
            "job 1 wants 512 MiB of memory, but the node has 256 MiB left");
}

}  // namespace
}  // namespace tessera

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <caf/all.hpp>
#include <cstdio>
#include <future>
#include <memory>
#include <utility>
#include <vector>

#include "actors/coordinator.h"
#include "actors/node_actor.h"
#include "actors/run_owner.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/delaunay/run/routed_shares.h"
#include "src/delaunay/run/run_options.h"
#include "src/geometry/reference/clouds.h"
#include "src/input/npy/array_source.h"

namespace tessera {
namespace {

class Config : public caf::actor_system_config {
 public:
  Config() { add_message_types<caf::id_block::tessera>(); }
};

// Parts with room for one tile in memory.
class NarrowParts final : public ShareSource {
 public:
  explicit NarrowParts(const RoutedCloud& run) {
    disk_.offer(std::shared_ptr<const RoutedCloud>(&run, [](const RoutedCloud*) {}), nullptr);
  }
  Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) override {
    BOOST_OUTCOME_TRY(share, disk_.open(spec, self));
    share->stages[0].schedule.memory_bytes = 1;
    return std::move(share);
  }

 private:
  RoutedShares disk_;
};

// Waits for the end.
class Waiting final : public RunOwner {
 public:
  void said(const std::string&) override {}
  void progressed(const RunProgress&) override {}
  void stored(const TileDone&) override {}
  void ended(RunEnded end) noexcept override {
    const auto told = end_;
    told->set_value(std::move(end));
  }
  RunEnded wait() { return end_->get_future().get(); }

 private:
  std::shared_ptr<std::promise<RunEnded>> end_ = std::make_shared<std::promise<RunEnded>>();
};

std::size_t heap_bytes() {
  const auto now = ::mallinfo2();
  return now.uordblks + now.hblkhd;
}

RoutedCloud routed(int dimension, std::uint32_t tiles, const std::filesystem::path& folder) {
  const auto coordinates = coordinates_of(make_cloud("uniform", dimension, 20 * tiles, 1), dimension);
  Progress progress;
  const Cloud cloud =
      Cloud::open_source(array_source("cloud", coordinates, dimension), {.dimension = dimension}).value();
  return route(cloud, run_folder(folder), {.tiles = tiles}, progress, {}).value();
}

// What the process has taken for a job of so many small tiles, when all are quiet and asleep, but for one.
std::size_t bytes_when_quiet(int dimension, std::uint32_t tiles) {
  const TemporaryFolder folder = TemporaryFolder::make().value();
  const RoutedCloud run = routed(dimension, tiles, folder.path());
  CoordinatorOptions job;
  job.spec = spec_of({}, run.folder.string(), folder.path().string());
  job.mark_settled = [](std::uint32_t, bool) -> Status { return success(); };
  std::size_t quiet = 0;
  job.weights = run.tile_points;
  job.on_quiet = [&](const RoutingTable&) { quiet = heap_bytes(); };
  Config config;
  caf::actor_system system(config);
  const std::size_t before = heap_bytes();
  const NodeHandle node = system.spawn<NodeActor>(NodeOptions{.memory_bytes = job.spec.memory_bytes, .hooks = {}},
                                                  std::make_shared<NarrowParts>(run));
  Waiting owner;
  system.spawn<Coordinator>(std::move(job), owner, std::vector<NodeHandle>{node});
  EXPECT_EQ(owner.wait().failure.text, "");
  caf::anon_send(node, Leave{});
  EXPECT_GT(quiet, before);
  return quiet - before;
}

// What the process takes for a share that has ten of so many tiles, beside the plan, when they are quiet and asleep.
std::size_t bytes_of_part(std::uint32_t tiles) {
  constexpr int dimension = 3;
  const TemporaryFolder folder = TemporaryFolder::make().value();
  const RoutedCloud run = routed(dimension, tiles, folder.path());
  ShareSpec spec = spec_of({}, run.folder.string(), folder.path().string());
  spec.table = {
      {}, 0, std::vector<NodeId>(run.tile_points.size(), NodeId{1}), std::vector<Incarnation>(run.tile_points.size())};
  std::fill_n(spec.table.nodes.begin(), 10, NodeId{0});
  Config config;
  caf::actor_system system(config);
  caf::scoped_actor self(system);
  const std::size_t before = heap_bytes();
  const NodeHandle node = system.spawn<NodeActor>(NodeOptions{.memory_bytes = spec.memory_bytes, .hooks = {}},
                                                  std::make_shared<NarrowParts>(run));
  self->send(node, OpenShare{JobId{1}, NodeId{0}, to_bytes(spec), caf::actor_cast<caf::actor>(self.ptr()), {}});
  ShareHandle share;
  self->receive([&](const ShareOpened& opened) {
    EXPECT_EQ(opened.failure.text, "");
    share = caf::actor_cast<ShareHandle>(opened.share);
    self->send(share, BeginShare{{opened.share, {}}, std::move(spec.table), false});
  });
  bool idle = false;
  self->receive_while([&] { return !idle; })([](const ShareBegun&) {}, [](const ShareProgress&) {},
                                             [&](const ShareIdle&) { idle = true; });
  const std::size_t after = heap_bytes();
  EXPECT_GT(after, before);
  self->monitor(share);
  self->send(share, Abort{});
  bool gone = false;
  self->receive_while([&] { return !gone; })([](const ShareProgress&) {}, [](const ShareEnded&) {},
                                             [&](const caf::down_msg&) { gone = true; });
  caf::anon_send(node, Leave{});
  return after - before;
}

// The table, whom tiles tell first, the tree over the seeds: nothing for each of other nodes' tiles but what any of its
// own may ask for.
TEST(TileMemory, IsLessThan128BytesForATileOfAnotherNode) {
  constexpr std::uint32_t few = 500, many = 5500;
  const auto least = [](std::uint32_t tiles) {
    return std::min({bytes_of_part(tiles), bytes_of_part(tiles), bytes_of_part(tiles), bytes_of_part(tiles)});
  };
  const std::size_t bytes = (least(many) - least(few)) / (many - few);
  std::printf("%zu bytes a tile of another node\n", bytes);
  EXPECT_LT(bytes, 128u);
}

// Actors, counters, schedule, and what tiles know of each other and the seeds: 100,000 tiles take 0.4 GB at most.
TEST(TileMemory, IsLessThan4KiBForATileAsleep) {
  for (const int dimension : {2, 3}) {
    constexpr std::uint32_t few = 50, many = 550;
    // What is on its way at that moment differs from run to run, and only adds.
    const auto least = [&](std::uint32_t tiles) {
      return std::min({bytes_when_quiet(dimension, tiles), bytes_when_quiet(dimension, tiles),
                       bytes_when_quiet(dimension, tiles), bytes_when_quiet(dimension, tiles)});
    };
    const std::size_t bytes = (least(many) - least(few)) / (many - few);
    std::printf("%dD: %zu bytes a tile\n", dimension, bytes);
    EXPECT_LT(bytes, 4096u);
  }
}

}  // namespace
}  // namespace tessera

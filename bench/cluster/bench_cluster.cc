// What a coordinator costs: the actors of many nodes in one process and one thread, a message at a time, each timed by
// the kind of actor that it was for. No network, no disk; tiles of few points, so that there is little beside control.
//   bench_cluster [nodes=4,16,64,256,1000] [tiles=10000] [points a tile=12] [seed=7] [ms between words of progress=100]
#include <sys/resource.h>
#include <time.h>

#include <caf/all.hpp>
#include <caf/scheduler/test_coordinator.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "actors/coordinator.h"
#include "actors/harness/memory_storage.h"
#include "actors/harness/setting.h"
#include "actors/node_actor.h"
#include "src/delaunay/run/touching.h"
#include "src/exchange/assignment.h"
#include "src/tiling/hilbert.h"

namespace tessera {
namespace {

// Of this thread's processor: others may use it, too.
std::chrono::nanoseconds processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

// First come, first served.
class TimedScheduler final : public caf::scheduler::test_coordinator {
 public:
  explicit TimedScheduler(caf::actor_system& system) : test_coordinator(system) {}
  void enqueue(caf::resumable* job) override { ready_.push_back(job); }
  void stop() override { run_all(); }

  void run_all() {
    Worker worker(*this);
    auto before = processor_time();
    while (!ready_.empty()) {
      caf::resumable* const job = ready_.front();
      ready_.pop_front();
      auto* const coordinator = dynamic_cast<Coordinator*>(job);
      if (coordinator) note(*coordinator);
      const auto state = job->resume(&worker, 1);
      const auto now = processor_time();
      const auto taken = now - std::exchange(before, now);
      all += taken;
      ++messages;
      if (coordinator) of_coordinator += taken;
      if (state == caf::resumable::resume_later) {
        enqueue(job);
      } else if (state != caf::resumable::shutdown_execution_unit) {
        caf::intrusive_ptr_release(job);
      }
    }
  }

  void forget() {
    all = of_coordinator = {};
    messages = of_waves = others = progress = 0;
  }

  std::chrono::nanoseconds all{}, of_coordinator{};
  std::uint64_t messages = 0;
  // Of these, to the coordinator; beside them one of each stored tile.
  std::uint64_t of_waves = 0, others = 0, progress = 0;

 private:
  // What it is about to hear.
  void note(Coordinator& coordinator) {
    caf::mailbox_element* const next = coordinator.mailbox().peek();
    if (!next || next->content().match_elements<TileDone>()) return;
    const caf::type_erased_tuple& message = next->content();
    const bool wave = message.match_elements<ShareIdle>() || message.match_elements<ShareTally>();
    ++(wave ? of_waves : message.match_elements<ShareProgress>() ? progress : others);
  }

  class Worker final : public caf::execution_unit {
   public:
    explicit Worker(TimedScheduler& scheduler) : execution_unit(&scheduler.system()), scheduler_(scheduler) {}
    void exec_later(caf::resumable* job) override { scheduler_.enqueue(job); }

   private:
    TimedScheduler& scheduler_;
  };
  std::deque<caf::resumable*> ready_;
};

class Config : public caf::actor_system_config {
 public:
  Config() {
    add_message_types<caf::id_block::tessera>();
    module_factories.push_back(
        [](caf::actor_system& system) -> caf::actor_system::module* { return new TimedScheduler(system); });
  }
};

class Owner final : public RunOwner {
 public:
  void progressed(const RunProgress&) override {}
  void said(const std::string&) override {}
  void stored(const TileDone&) override { ++tiles; }
  void ended(RunEnded how) noexcept override { end = std::move(how); }
  std::optional<RunEnded> end;
  std::uint64_t tiles = 0;
};

// A uniform cloud in 2D, as production would cut it and find its seeds.
Setting uniform_setting(std::uint32_t tiles, std::size_t points, unsigned seed, std::vector<TileId>& order) {
  Setting s;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Point> sample;
  Bounds bounds;
  for (std::size_t i = 0; i < points; ++i) {
    s.cloud.push_back({{unit(random), unit(random), 0}, i});
    sample.push_back(s.cloud.back().at);
    bounds.add(sample.back());
  }
  const auto partition =
      std::make_shared<const Partition>(Partition::build_tiles(PartitionKind::kdtree, 2, sample, bounds, tiles));
  CutCloud own = cut(s.cloud, *partition);
  s.tiles = std::move(own.tiles);
  s.tile_points = points_of(s.tiles);
  s.stage.dimension = 2;
  s.stage.boxes = final_boxes(partition);
  const auto neighbours = touching_tiles(*partition, own.bounds);
  s.stage.around = std::make_shared<const KnownFromStart>(std::move(own.bounds), neighbours, std::move(own.seeds));
  s.context.many_nodes = s.schedule.settle_asleep = true;
  s.schedule.memory_bytes = std::uint64_t{1} << 40;
  std::vector<std::uint64_t> place(s.tiles.size());
  const HilbertKey key(bounds, 2);
  for (std::uint32_t t = 0; t < s.tiles.size(); ++t) {
    if (s.tiles[t].empty()) continue;
    order.push_back(TileId{t});
    const Bounds& b = s.stage.around->bounds(TileId{t});
    place[t] = key({b.lo.x / 2 + b.hi.x / 2, b.lo.y / 2 + b.hi.y / 2, 0});
  }
  std::stable_sort(order.begin(), order.end(), [&](TileId a, TileId b) { return place[a.value] < place[b.value]; });
  return s;
}

// The most that the process has had in memory, so far.
long peak_mebibytes() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_maxrss / 1024;
}

double seconds(std::chrono::nanoseconds time) { return std::chrono::duration<double>(time).count(); }

int run(std::uint32_t nodes, std::uint32_t tiles, std::size_t points, unsigned seed,
        std::chrono::milliseconds progress) {
  CoordinatorOptions job;
  Setting setting = uniform_setting(tiles, points, seed, job.order);
  job.weights = *setting.tile_points;
  std::vector<Host> hosts;
  for (std::uint32_t n = 0; n < nodes; ++n) hosts.push_back({NodeId{n}, 1});
  setting.spec.table = {
      {}, 0, std::vector<NodeId>(setting.tiles.size()), std::vector<Incarnation>(setting.tiles.size())};
  const auto homes = share_out(job.order, job.weights, hosts);
  for (std::size_t i = 0; i < homes.size(); ++i) setting.spec.table.nodes[job.order[i].value] = homes[i];
  setting.table = std::make_shared<const RoutingTable>(setting.spec.table);
  job.spec = setting.spec;
  job.mark_settled = [](std::uint32_t, bool) { return success(); };
  MemoryStorage storage(2, setting.tiles);
  Owner owner;
  Config config;
  caf::actor_system system(config);
  auto& scheduler = dynamic_cast<TimedScheduler&>(system.scheduler());
  std::vector<NodeHandle> handles;
  for (std::uint32_t n = 0; n < nodes; ++n) {
    NodeOptions node;
    node.memory_bytes = ~std::uint64_t{0};
    node.progress_interval = progress;
    handles.push_back(system.spawn<NodeActor>(
        std::move(node),
        std::make_shared<MemoryShares>(setting, storage, std::vector<ExchangeWatch*>{nullptr}, NodeId{n})));
  }
  scheduler.run_all();
  scheduler.forget();
  system.spawn<Coordinator>(std::move(job), owner, handles);
  scheduler.run_all();
  for (const NodeHandle& node : handles) caf::anon_send_exit(node, caf::exit_reason::kill);
  handles.clear();
  const double all = seconds(scheduler.all), coordinator = seconds(scheduler.of_coordinator);
  const std::uint64_t messages = scheduler.messages;
  const auto a_node = [&](std::uint64_t told) { return static_cast<double>(told) / nodes; };
  const double of_waves = a_node(scheduler.of_waves), others = a_node(scheduler.others),
               progress_told = a_node(scheduler.progress);
  scheduler.run_all();
  if (!owner.end || owner.end->failure || owner.tiles != homes.size()) {
    std::fprintf(stderr, "%u nodes: %s\n", nodes, owner.end ? owner.end->failure.text.c_str() : "no end");
    return 1;
  }
  std::printf(
      "%5u nodes %6llu tiles %9llu messages %7.2f s   coordinator %8.4f s %5.2f %%   %llu waves   a node tells it: "
      "%.2f a "
      "wave, %.2f beside, %.1f of progress   %ld MiB\n",
      nodes, static_cast<unsigned long long>(owner.tiles), static_cast<unsigned long long>(messages), all, coordinator,
      100 * coordinator / all, static_cast<unsigned long long>(owner.end->waves),
      of_waves / static_cast<double>(owner.end->waves), others, progress_told, peak_mebibytes());
  return 0;
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  const auto value = [&](int i, unsigned long otherwise) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : otherwise;
  };
  std::istringstream nodes(argc > 1 ? argv[1] : "4,16,64,256,1000");
  const auto tiles = static_cast<std::uint32_t>(value(2, 10'000));
  const std::size_t points = value(3, 12) * tiles;
  int failed = 0;
  for (std::string n; std::getline(nodes, n, ',');) {
    failed |= tessera::run(static_cast<std::uint32_t>(std::strtoul(n.c_str(), nullptr, 10)), tiles, points,
                           static_cast<unsigned>(value(4, 7)), std::chrono::milliseconds(value(5, 100)));
  }
  return failed;
}

#include "actors/harness.h"

#include <algorithm>
#include <caf/all.hpp>
#include <caf/scheduler/test_coordinator.hpp>
#include <map>
#include <random>
#include <utility>

#include "actors/coordinator.h"
#include "actors/network.h"
#include "actors/node_actor.h"
#include "actors/tile_actor.h"
#include "actors/touching.h"
#include "src/harness/clouds.h"
#include "src/harness/reference.h"
#include "src/tiling/span_finder.h"

namespace tessera {
namespace {

class MemoryStorage final : public TileStorage {
 public:
  MemoryStorage(int dimension, std::vector<std::vector<LocalPoint>> points)
      : dimension_(dimension), points_(std::move(points)) {}

  Result<LoadedTile> load_points(TileId tile) override { return order_points(points_[tile.value], dimension_); }
  Status put(TileId tile, Scratch what, std::span<const std::byte> bytes, bool append) override {
    auto& kept = scratch_[{tile, what}];
    if (!append) kept.clear();
    kept.insert(kept.end(), bytes.begin(), bytes.end());
    return success();
  }
  Result<std::vector<std::byte>> take(TileId tile, Scratch what) override {
    return std::exchange(scratch_[{tile, what}], {});
  }
  void store(TileId tile, TileMesh mesh, Stored done) override {
    meshes_.push_back(std::move(mesh));
    TileEntry entry;
    entry.tile = tile.value;
    done(entry);
  }
  const std::vector<TileMesh>& meshes() const { return meshes_; }

 private:
  int dimension_;
  std::vector<std::vector<LocalPoint>> points_;
  std::map<std::pair<TileId, Scratch>, std::vector<std::byte>> scratch_;
  std::vector<TileMesh> meshes_;
};

class DeterministicConfig : public caf::actor_system_config {
 public:
  DeterministicConfig() {
    add_message_types<caf::id_block::tessera>();
    set("scheduler.policy", caf::atom("testing"));
  }
};

// Runs one message of a random ready actor.
bool step(caf::scheduler::test_coordinator& scheduler, std::mt19937_64& rng) {
  if (scheduler.jobs.empty()) return false;
  const auto chosen = scheduler.jobs.begin() + static_cast<std::ptrdiff_t>(rng() % scheduler.jobs.size());
  auto* job = *chosen;
  scheduler.jobs.erase(chosen);
  scheduler.jobs.push_front(job);
  return scheduler.try_run_once();
}

struct Setting {
  TileContext context;
  NodeOptions node;
  std::vector<LocalPoint> cloud;
  std::vector<std::vector<LocalPoint>> tiles;
};

Setting make_setting(const HarnessOptions& options, std::uint64_t seed) {
  Setting s;
  const int d = options.dimension;
  s.cloud = make_cloud(options.kind, d, options.points, seed);
  std::vector<Point> sample;
  Bounds bounds;
  for (const LocalPoint& p : s.cloud) {
    sample.push_back(p.at);
    bounds.add(p.at);
  }
  const Partition partition = Partition::build_tiles(options.partition, d, sample, bounds, options.tiles);
  s.tiles.resize(partition.tiles());
  std::vector<Bounds> tile_bounds(partition.tiles());
  SpanFinder finder(d);
  for (const LocalPoint& p : s.cloud) {
    const TileId tile = partition.tile_of(p.at);
    s.tiles[tile.value].push_back(p);
    tile_bounds[tile.value].add(p.at);
  }
  finder.add(s.cloud);
  std::vector<LocalPoint> seeds = finder.span();
  if (std::find(seeds.begin(), seeds.end(), finder.least()) == seeds.end()) seeds.push_back(finder.least());
  for (const LocalPoint& p : seeds) s.context.seeds.push_back({p.at, p.id, partition.tile_of(p.at).value, 0});
  s.context.dimension = d;
  s.context.reduce = seed % 2 == 0;
  s.context.boxes = final_boxes(partition);
  if (seed % 3 != 0) {
    s.context.neighbours = touching_tiles(partition, tile_bounds);
  } else {  // no directed exchange: everything hangs on rules S and C
    s.context.neighbours.resize(partition.tiles());
  }
  s.node.threads = 1 + static_cast<std::uint32_t>(seed % 4);
  s.node.triangulate_bytes = 1000;
  s.node.collect_bytes = 1000;
  // Every tile sleeps whenever it can; or there is room for half of them, which work beside those that fall asleep.
  const std::uint64_t half = s.cloud.size() * s.node.triangulate_bytes / 2;
  s.node.memory_bytes = seed % 5 == 0 ? 1 : seed % 5 == 1 ? half : std::uint64_t{1} << 40;
  for (const auto& points : s.tiles) s.node.points.push_back(points.size());
  return s;
}

struct Outcome {
  std::string failure;
  std::uint64_t steps = 0, waves = 0;
  RunSummary summary;
  std::uint64_t batches = 0;
};

Outcome run_seed(const HarnessOptions& options, std::uint64_t seed) {
  constexpr std::uint64_t steps_max = 20'000'000;
  Outcome outcome;
  std::mt19937_64 rng(seed);
  Setting setting = make_setting(options, seed);
  Progress progress;
  setting.context.progress = &progress;
  MemoryStorage storage(options.dimension, setting.tiles);
  setting.context.storage = &storage;
  RunLog log;
  NetworkState network;
  bool quiet = false;
  std::optional<RunEnded> ended;
  {
    DeterministicConfig config;
    Directory directory;
    directory.trace = options.trace;
    caf::actor_system system(config);
    auto& scheduler = dynamic_cast<caf::scheduler::test_coordinator&>(system.scheduler());
    caf::scoped_actor self(system, true);
    const auto coordinator = self->spawn<Coordinator>(
        caf::actor_cast<caf::actor>(self.ptr()), 1u, std::function<void()>([&] {
          quiet = true;
          directory.tell([] { return std::string("coordinator: quiet"); });
          if (network.held > 0 || progress.batches_sent != progress.batches_processed) {
            outcome.failure = "quiescence believed with " +
                              std::to_string(progress.batches_sent - progress.batches_processed) +
                              " batches not processed";
          }
        }));
    directory.tiles.resize(setting.tiles.size());
    for (std::uint32_t t = 0; t < setting.tiles.size(); ++t) {
      if (setting.tiles[t].empty()) continue;
      directory.tiles[t] = self->spawn<TileActor>(Peer{TileId{t}, 0}, std::cref(setting.context), std::cref(directory));
    }
    // Some networks are so slow that whole waves pass while a batch is on its way.
    const auto patience = static_cast<std::uint32_t>(seed % 7 == 0 ? 400 : seed % 7);
    directory.network = self->spawn<Network>(std::cref(directory), std::ref(network), rng(), patience);
    directory.node =
        self->spawn<NodeActor>(std::cref(setting.node), std::cref(directory), std::ref(log), coordinator, &progress);
    self->send(coordinator, std::vector<caf::actor>{directory.node});
    while (outcome.failure.empty() && outcome.steps < steps_max && step(scheduler, rng)) ++outcome.steps;
    while (self->has_next_message()) {
      self->receive([](const RunQuiet&) {}, [&](RunEnded& message) { ended = std::move(message); });
    }
    for (const auto& tile : directory.tiles) {
      if (tile) caf::anon_send_exit(tile, caf::exit_reason::kill);
    }
    for (const auto& actor : {directory.network, directory.node, coordinator}) {
      caf::anon_send_exit(actor, caf::exit_reason::kill);
    }
    scheduler.run();
    directory = {};
  }
  outcome.summary = std::move(log.summary);
  outcome.batches = progress.batches_sent;
  if (!outcome.failure.empty()) return outcome;
  if (!quiet || !ended) {
    outcome.failure = "no end after " + std::to_string(outcome.steps) + " steps";
  } else if (ended->code != 0) {
    outcome.failure = ended->text;
  } else {
    outcome.waves = ended->waves;
    outcome.failure = difference(global_delaunay(setting.cloud, options.dimension), main_cells(storage.meshes()));
  }
  return outcome;
}

}  // namespace

HarnessReport run_harness(const HarnessOptions& options) {
  HarnessReport report;
  for (std::uint64_t seed = options.first_seed; seed <= options.last_seed; ++seed) {
    const Outcome outcome = run_seed(options, seed);
    report.steps += outcome.steps;
    report.batches += outcome.batches;
    report.waves += outcome.waves;
    report.sleeps += outcome.summary.sleeps;
    if (!outcome.failure.empty()) {
      report.failed_seed = seed;
      report.failure = outcome.failure;
      return report;
    }
    ++report.seeds;
  }
  return report;
}

}  // namespace tessera

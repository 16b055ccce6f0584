#include "actors/engine.h"

#include <algorithm>
#include <atomic>
#include <caf/all.hpp>
#include <chrono>
#include <future>
#include <optional>
#include <utility>

#include "actors/coordinator.h"
#include "actors/failing.h"
#include "actors/node_actor.h"
#include "actors/prepared.h"
#include "actors/scheduler.h"
#include "src/run/disk_parts.h"

namespace tessera {
namespace {

class EngineConfig : public caf::actor_system_config {
 public:
  explicit EngineConfig(std::uint32_t threads) {
    add_message_types<caf::id_block::tessera>();
    set("scheduler.max-threads", deciding_threads + threads);
    module_factories.push_back(
        [](caf::actor_system& system) -> caf::actor_system::module* { return new Scheduler(system); });
  }
};

Phase phase_of(RunStage stage) {
  switch (stage) {
    case RunStage::triangulating:
      return Phase::triangulating;
    case RunStage::splaying:
      return Phase::splaying;
    case RunStage::collecting:
      break;
  }
  return Phase::collecting;
}

Phase phase_of(Work work) {
  if (work == Work::begin) return Phase::triangulating;
  return work == Work::collect ? Phase::collecting : Phase::splaying;
}

void show(const RunProgress& from, double opened_s, Progress& to) {
  to.phase = phase_of(from.stage);
  const PartProgress& sum = from.sum;
  to.points_triangulated = sum.points_begun;
  to.tiles_triangulated = static_cast<std::uint32_t>(sum.tiles_begun);
  to.tiles_stored = static_cast<std::uint32_t>(sum.tiles_stored);
  to.tiles_asleep = static_cast<std::uint32_t>(sum.tiles_asleep);
  to.updates_sent = sum.updates_sent;
  to.updates_processed = sum.updates_processed;
  to.points_sent = sum.points_sent;
  to.memory_bytes = sum.memory_bytes;
  for (const WorkSpan& span : sum.spans) {
    to.add_span({phase_of(span.work), span.tile, span.thread, opened_s + static_cast<double>(span.begin_us) * 1e-6,
                 opened_s + static_cast<double>(span.end_us) * 1e-6});
  }
}

double seconds(std::uint64_t microseconds) { return static_cast<double>(microseconds) * 1e-6; }

RunSummary summary_of(const RunEnded& ended, std::vector<TileDone> done) {
  std::sort(done.begin(), done.end(), [](const TileDone& a, const TileDone& b) { return a.entry.tile < b.entry.tile; });
  RunSummary summary;
  for (const TileDone& tile : done) {
    summary.tiles.push_back(tile.entry);
    summary.tile_seconds.push_back(seconds(tile.microseconds));
    summary.vertices += tile.entry.own_points;
    summary.cells += tile.entry.main_cells;
  }
  summary.exchange.points = ended.sum.points;
  summary.exchange.updates = ended.sum.updates;
  summary.exchange.hops = ended.sum.hops;
  summary.exchange.most_received = ended.sum.most_received;
  summary.exchange.sleeps = ended.sum.sleeps;
  summary.exchange.work = {seconds(ended.sum.begin_us), seconds(ended.sum.splay_us), seconds(ended.sum.collect_us)};
  summary.exchange.waves = ended.waves;
  summary.wall = {seconds(ended.triangulate_us), seconds(ended.splay_us), seconds(ended.collect_us)};
  return summary;
}

// The one who called Engine::run().
class Caller final : public RunOwner {
 public:
  explicit Caller(Progress& progress) : progress_(progress) {}

  void progressed(const RunProgress& now) override { show(now, opened_s_, progress_); }
  void stored(const TileDone& tile) override { done_.push_back(tile); }
  void ended(RunEnded end) noexcept override {
    const auto told = end_;  // whoever waits may be gone before this returns
    told->set_value(std::move(end));
  }

  RunEnded wait() { return end_->get_future().get(); }
  std::vector<TileDone> take_done() { return std::move(done_); }

 private:
  Progress& progress_;
  const double opened_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - progress_.started).count();
  std::vector<TileDone> done_;
  std::shared_ptr<std::promise<RunEnded>> end_ = std::make_shared<std::promise<RunEnded>>();
};

}  // namespace

struct Engine::Impl {
  Impl(std::uint32_t threads, std::uint64_t memory_bytes) : config(threads), system(config) {
    NodeOptions options;
    options.memory_bytes = memory_bytes;
    node = system.spawn<NodeActor>(std::move(options), source);
  }
  ~Impl() {
    leave.say(node);
    node = nullptr;
  }

  // `again`: see RunEnded.
  Result<RunSummary> run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                         Progress& progress, const std::stop_token& stop, bool& again);

  EngineConfig config;
  std::shared_ptr<DiskParts> source = std::make_shared<DiskParts>();
  Prepared<Leave> leave;
  caf::actor_system system;
  NodeHandle node;
  std::atomic<std::uint64_t> jobs{0};
};

Result<RunSummary> Engine::Impl::run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                                     Progress& progress, const std::stop_token& stop, bool& again) {
  progress.tiles_total = static_cast<std::uint32_t>(
      std::count_if(run.tile_points.begin(), run.tile_points.end(), [](auto n) { return n > 0; }));
  progress.phase = Phase::triangulating;

  // Tiles and writers hold on to the run: when the last of them has let go, nothing works on it any more.
  const auto let_go = std::make_shared<std::promise<void>>();  // shared: whoever lets go last may still be at it below
  auto gone = let_go->get_future();
  std::shared_ptr<const RoutedRun> lent(&run, [let_go](const RoutedRun*) { let_go->set_value(); });

  CoordinatorOptions job;
  job.job = JobId{++jobs};
  job.spec = {options, run.folder.string(), out.string(), {}};
  job.points = run.tile_points;
  for (std::uint32_t t = 0; t < run.tile_points.size(); ++t) {
    if (run.tile_points[t] > 0) job.order.push_back(TileId{t});
  }
  job.mark_settled = [&](bool settled) { return mark_settled(run, options.lock_file, settled); };

  Caller caller(progress);
  Prepared<Cancel> prepared_cancel;
  source->offer(std::move(lent));
  RunEnded end;
  try {
    const auto coordinator = system.spawn<Coordinator>(std::move(job), caller, std::vector<NodeHandle>{node});
    const std::stop_callback cancel(stop, [&] { prepared_cancel.say(coordinator); });
    end = caller.wait();
  } catch (...) {  // there is no coordinator
    source->withdraw(run);
    throw;
  }
  source->withdraw(run);
  gone.wait();
  again = end.again;
  if (end.failure) return error_of(std::move(end.failure));
  return summary_of(end, caller.take_done());
}

Engine::Engine(std::uint32_t threads, std::uint64_t memory_bytes)
    : impl_(std::make_unique<Impl>(threads, memory_bytes)) {}

Engine::~Engine() = default;

Result<RunSummary> Engine::run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                               Progress& progress, std::stop_token stop) {
  bool again = false;
  auto summary = impl_->run(run, out, options, progress, stop, again);
  // Once: where damage follows damage, nothing should go on.
  if (again) summary = impl_->run(run, out, options, progress, stop, again);
  return summary;
}

}  // namespace tessera

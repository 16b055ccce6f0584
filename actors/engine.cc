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
#include "src/run/disk_parts.h"

namespace tessera {
namespace {

class EngineConfig : public caf::actor_system_config {
 public:
  explicit EngineConfig(std::uint32_t threads) {
    add_message_types<caf::id_block::tessera>();
    set("scheduler.max-threads", static_cast<std::size_t>(threads));
    set("scheduler.policy", caf::atom("sharing"));
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
  to.batches_sent = sum.batches_sent;
  to.batches_processed = sum.batches_processed;
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
  summary.exchange.batches = ended.sum.batches;
  summary.exchange.rounds = ended.sum.rounds;
  summary.exchange.sleeps = ended.sum.sleeps;
  summary.exchange.work = {seconds(ended.sum.begin_us), seconds(ended.sum.splay_us), seconds(ended.sum.collect_us)};
  summary.exchange.waves = ended.waves;
  summary.wall = {seconds(ended.triangulate_us), seconds(ended.splay_us), seconds(ended.collect_us)};
  return summary;
}

}  // namespace

struct Engine::Impl {
  Impl(std::uint32_t threads, std::uint64_t memory_bytes) : config(threads), system(config) {
    NodeOptions options;
    options.memory_bytes = memory_bytes;
    node = system.spawn<NodeActor, caf::detached>(std::move(options), source);
  }
  ~Impl() {
    caf::anon_send_exit(node, caf::exit_reason::user_shutdown);
    node = nullptr;
  }

  // `again`: see RunEnded.
  Result<RunSummary> run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                         Progress& progress, const std::stop_token& stop, bool& again);

  EngineConfig config;
  std::shared_ptr<DiskParts> source = std::make_shared<DiskParts>();
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
  std::shared_ptr<const RoutedRun> lent(&run, [let_go](const RoutedRun*) { let_go->set_value(); });
  source->offer(lent);

  CoordinatorOptions job;
  job.job = JobId{++jobs};
  job.spec = {options, run.folder.string(), out.string(), {}, {}};
  job.mark_settled = [&](bool settled) { return mark_settled(run, options.lock_file, settled); };

  std::vector<TileDone> done;
  std::optional<RunEnded> ended;
  {
    caf::scoped_actor self(system);
    const double opened_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - progress.started).count();
    const auto coordinator = self->spawn<Coordinator, caf::detached + caf::monitored>(
        std::move(job), caf::actor_cast<caf::actor>(self.ptr()), std::vector<NodeHandle>{node});
    const std::stop_callback cancel(stop, [&coordinator] { caf::anon_send(coordinator, Cancel{}); });
    bool running = true;
    self->receive_while(running)([&](const RunProgress& now) { show(now, opened_s, progress); },
                                 [&](TileDone& tile) { done.push_back(tile); },
                                 [&](RunEnded& message) {
                                   if (!ended) ended = std::move(message);
                                 },
                                 [&](const caf::down_msg& down) {  // its last message came before
                                   if (!ended) ended.emplace().failure = lost("the coordinator", down.reason);
                                   running = false;
                                 });
  }
  source->withdraw(run);
  lent.reset();
  let_go->get_future().wait();
  again = ended->again;
  if (ended->failure) return error_of(ended->failure);
  return summary_of(*ended, std::move(done));
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

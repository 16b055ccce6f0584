#include "actors/engine/engine.h"

#include <algorithm>
#include <atomic>
#include <caf/all.hpp>
#include <future>
#include <utility>

#include "actors/coordinator.h"
#include "actors/engine/caller.h"
#include "actors/engine/cluster_router.h"
#include "actors/engine/membership.h"
#include "actors/failing.h"
#include "actors/node_actor.h"
#include "actors/prepared.h"
#include "actors/scheduler.h"
#include "src/budget/budget.h"
#include "src/exchange/terms.h"
#include "src/run/disk_parts.h"
#include "src/store/tile_store.h"
#include "src/tiling/hilbert.h"

namespace tessera {
namespace {

class EngineConfig : public caf::actor_system_config {
 public:
  EngineConfig(std::uint32_t threads, Membership* cluster) {
    add_message_types<caf::id_block::tessera>();
    set("scheduler.max-threads", deciding_threads + threads);
    module_factories.push_back(
        [](caf::actor_system& system) -> caf::actor_system::module* { return new Scheduler(system); });
    if (cluster) cluster->prepare(*this);
  }
};

// The last stage that is settled, or the first one: what it has settled comes to its end.
Result<std::uint32_t> first_stage(const std::filesystem::path& run, std::uint32_t stages) {
  BOOST_OUTCOME_TRY(settled, settled_stages(run, stages));
  return std::max(settled, 1U) - 1;
}

}  // namespace

struct Engine::Impl {
  Impl(std::uint32_t own_threads, std::uint64_t memory_bytes, std::unique_ptr<Membership> membership, NextStages after)
      : threads(own_threads),
        next(std::move(after)),
        seat(std::move(membership)),
        config(threads, seat.get()),
        source(std::make_shared<DiskParts>(seat ? seat->options().scratch : std::filesystem::path(), next)),
        system(config) {
    if (seat && !seat->options().node) return;
    NodeOptions own;
    if (seat) {
      own.name = seat->options().node_name;
      own.data = seat->options().data;
    }
    own.threads = threads;
    own.memory_bytes = memory_bytes;
    own.used = used;
    own.meter = meter;
    node = system.spawn<NodeActor>(std::move(own), source);
  }
  ~Impl() {
    if (seat) seat->leave();
    leave.say(node);
    node = nullptr;
  }

  // `again`: see RunEnded.
  Result<RunSummary> run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                         Progress& progress, const std::stop_token& stop, bool& again);
  Result<std::vector<NodeHandle>> prepare(CoordinatorOptions& job, const RoutedRun& run, KernelKind kernel,
                                          const std::stop_token& stop);

  const std::uint32_t threads;
  const NextStages next;
  const std::unique_ptr<Membership> seat;  // null: alone
  EngineConfig config;
  std::shared_ptr<DiskParts> source;
  std::shared_ptr<std::atomic<std::uint64_t>> used = std::make_shared<std::atomic<std::uint64_t>>();
  const std::shared_ptr<NodeMeter> meter = std::make_shared<NodeMeter>();
  Prepared<Leave> leave;
  caf::actor_system system;
  NodeHandle node;
  std::atomic<std::uint64_t> jobs{0};
};

// What a job of a cluster has beyond one node's, and the nodes that it begins with.
Result<std::vector<NodeHandle>> Engine::Impl::prepare(CoordinatorOptions& job, const RoutedRun& run, KernelKind kernel,
                                                      const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(identity, identity_of(run.folder));
  BOOST_OUTCOME_TRY(term, claim_term(run.folder));
  job.job = identity;
  job.term = term;
  job.take_over = true;
  job.replaced = [folder = run.folder, term] { return is_replaced(folder, term); };
  job.is_settled = [folder = run.folder](std::uint32_t stage) -> Result<bool> {
    BOOST_OUTCOME_TRY(settled, settled_stages(folder, stage + 1));
    return settled > stage;
  };
  job.first_stage = [folder = run.folder, stages = job.stages] { return first_stage(folder, stages); };
  job.stored = [out = std::filesystem::path(job.spec.out_folder), stages = next](std::uint32_t stage) {
    return stored_by(stages, out, stage, [](TileId) { return true; });
  };
  job.weight_max = [dimension = run.dimension, kernel](std::uint32_t own, std::uint64_t bytes) {
    return budget::tile_points_max(dimension, kernel, own, bytes);
  };
  job.tile_in_words = [dimension = run.dimension, kernel](std::uint64_t points) {
    const std::uint64_t bytes = budget::tile_working_bytes(dimension, kernel, points);
    return "a tile of " + std::to_string(points) + " points, which needs about " + std::to_string((bytes >> 20) + 1) +
           " MiB";
  };
  job.spec.shares = seat->options().jobs_at_once;
  job.spec.grace_s = seat->options().grace_s;
  job.spec.resumable = false;  // images are of use to their own node alone
  // Whose writing counts is told by incarnations, and the next coordinator has another lock.
  job.spec.lock_file.clear();
  auto nodes = seat->nodes(term > Term{1}, stop);
  if (nodes.empty()) return error(Errc::interrupted, "interrupted");
  return nodes;
}

Result<RunSummary> Engine::Impl::run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                                     Progress& progress, const std::stop_token& stop, bool& again) {
  progress.tiles_total = static_cast<std::uint32_t>(
      std::count_if(run.tile_points.begin(), run.tile_points.end(), [](auto n) { return n > 0; }));
  progress.phase = phase_of(ProgramKind::delaunay, ProgramStep::begin);

  // Tiles and writers hold on to the run: when the last of them has let go, nothing works on it any more.
  const auto let_go = std::make_shared<std::promise<void>>();  // shared: whoever lets go last may still be at it below
  auto gone = let_go->get_future();
  std::shared_ptr<const RoutedRun> lent(&run, [let_go](const RoutedRun*) { let_go->set_value(); });

  CoordinatorOptions job;
  job.job = JobId{++jobs};
  job.spec = spec_of(options, run.folder.string(), out.string());
  job.weights = run.tile_points;
  for (std::uint32_t t = 0; t < run.tile_points.size(); ++t) {
    if (run.tile_points[t] > 0) job.order.push_back(TileId{t});
  }
  // A node's tiles are near each other, so that most neighbours are at home.
  const HilbertKey key(run.bounds, run.dimension);
  std::vector<std::uint64_t> place(run.tile_points.size());
  for (const TileId t : job.order) {
    const Bounds& b = run.tile_bounds[t.value];
    place[t.value] = key({b.lo.x / 2 + b.hi.x / 2, b.lo.y / 2 + b.hi.y / 2, b.lo.z / 2 + b.hi.z / 2});
  }
  std::stable_sort(job.order.begin(), job.order.end(),
                   [&](TileId a, TileId b) { return place[a.value] < place[b.value]; });
  job.stages = static_cast<std::uint32_t>(next.size()) + 1;
  BOOST_OUTCOME_TRY(first, first_stage(run.folder, job.stages));
  job.spec.table.stage = first;
  job.mark_settled = [&](std::uint32_t stage, bool settled) {
    return mark_settled(run.folder, stage, options.lock_file, settled);
  };
  std::vector<NodeHandle> nodes{node};
  if (seat) {
    BOOST_OUTCOME_TRY(free, prepare(job, run, options.kernel, stop));
    nodes = std::move(free);
  }

  RunCaller caller(progress);
  Prepared<Cancel> prepared_cancel;
  source->offer(std::move(lent), options.taker);
  RunEnded end;
  try {
    const auto coordinator = system.spawn<Coordinator>(std::move(job), caller, std::move(nodes));
    if (seat) seat->follow(coordinator);
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
  if (!next.empty()) {  // one that took office in a later stage has heard nothing of the first
    BOOST_OUTCOME_TRY(stored, stored_by({}, out, 0, [](TileId) { return true; }));
    for (const TileReceipt& tile : stored) caller.know(tile);
  }
  return caller.summary(end);
}

Engine::Engine(std::uint32_t threads, std::uint64_t memory_bytes, NextStages next)
    : impl_(std::make_unique<Impl>(threads, memory_bytes, nullptr, std::move(next))) {}

Engine::Engine(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Engine>> Engine::join(std::uint32_t threads, std::uint64_t memory_bytes,
                                             std::unique_ptr<Membership> membership, NextStages next) {
  auto impl = std::make_unique<Impl>(threads, memory_bytes, std::move(membership), std::move(next));
  Membership::Own own;
  own.node = caf::actor_cast<caf::actor>(impl->node);
  own.threads = threads;
  own.memory_bytes = memory_bytes;
  own.memory_used = [used = impl->used] { return used->load(); };
  own.jobs = [meter = impl->meter] { return meter->now().parts; };
  BOOST_OUTCOME_TRYV(impl->seat->take(impl->system, own));
  return std::unique_ptr<Engine>(new Engine(std::move(impl)));
}

Engine::~Engine() = default;

Result<RunSummary> Engine::run(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                               Progress& progress, std::stop_token stop) {
  bool again = false;
  auto summary = impl_->run(run, out, options, progress, stop, again);
  // Once: where damage follows damage, nothing should go on.
  if (again) summary = impl_->run(run, out, options, progress, stop, again);
  return summary;
}

std::unique_ptr<StretchRouter> Engine::router(std::uint64_t memory_bytes) const {
  if (!impl_->seat) return nullptr;
  return std::make_unique<ClusterRouter>(impl_->system, *impl_->seat, memory_bytes);
}

std::uint32_t Engine::threads() const {
  if (!impl_->seat) return impl_->threads;
  std::uint32_t sum = 0;
  for (const NodeState& member : impl_->seat->members()) sum += member.free ? member.info.threads : 0;
  return std::max(1U, sum);
}

std::vector<budget::NodeShare> Engine::shares() const {
  std::vector<budget::NodeShare> shares;
  if (!impl_->seat) return shares;
  const std::uint32_t jobs = impl_->seat->options().jobs_at_once;
  for (const NodeState& node : impl_->seat->members()) {
    if (node.free)
      shares.push_back({node.info.name, std::max(1U, node.info.threads / jobs), node.info.memory_bytes / jobs});
  }
  return shares;
}

NodeWork Engine::work() const { return impl_->meter->now(); }

std::uint64_t Engine::memory_used() const { return impl_->used->load(); }

NodePlace Engine::place() const { return impl_->seat->place(); }

void Engine::depart() const { impl_->seat->depart(); }

bool Engine::gathering() const { return impl_->seat && impl_->seat->gathering(); }

std::vector<NodeState> Engine::nodes() const { return impl_->seat->members(); }

std::uint64_t Engine::nodes_lost() const { return impl_->seat->lost(); }

Result<bool> Engine::drain(const std::string& node) const { return impl_->seat->drain(node); }

}  // namespace tessera

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
#include "actors/engine/stages_caller.h"
#include "actors/failing.h"
#include "actors/node_actor.h"
#include "actors/prepared.h"
#include "actors/scheduler.h"
#include "src/base/files/names.h"
#include "src/base/files/whole_file.h"
#include "src/delaunay/run/result_shares.h"
#include "src/delaunay/run/routed_shares.h"
#include "src/delaunay/run/settled_stages.h"
#include "src/exchange/terms.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/budget/budget.h"
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

// Returns the last stage that is settled, or the first one. The job begins with it: what is settled comes to its end.
Result<std::uint32_t> first_stage(const std::filesystem::path& run, std::uint32_t stages) {
  BOOST_OUTCOME_TRY(settled, settled_stages(run, stages));
  return std::max(settled, 1U) - 1;
}

// Opens shares of all kinds of jobs.
class AllShares final : public ShareSource {
 public:
  AllShares(std::filesystem::path scratch, KindsOfStages kinds)
      : clouds(scratch), results(std::move(scratch), std::move(kinds)) {}
  Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) override {
    return spec.stages.empty() ? clouds.open(spec, self) : results.open(spec, self);
  }
  RoutedShares clouds;
  ResultShares results;
};

}  // namespace

struct Engine::Impl {
  Impl(std::uint32_t own_threads, std::uint64_t memory_bytes, std::unique_ptr<Membership> membership,
       KindsOfStages kinds)
      : threads(own_threads),
        seat(std::move(membership)),
        config(threads, seat.get()),
        source(std::make_shared<AllShares>(seat ? seat->options().scratch : std::filesystem::path(), std::move(kinds))),
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

  // `again` is set as in RunEnded.
  Result<RunSummary> run(const RoutedCloud& run, const std::filesystem::path& out, const RunOptions& options,
                         Progress& progress, const std::stop_token& stop, bool& again);
  Status run(const ResultJob& result_job, const std::function<void(double)>& fraction, Progress& progress,
             const std::stop_token& stop, bool& again);
  // Sets what all jobs have in common, and returns the nodes with which the job begins.
  Result<std::vector<NodeHandle>> prepare(CoordinatorOptions& job, const std::stop_token& stop);
  // Runs a job from the first message to the last one. `caller` is told of all that happens.
  template <class Caller>
  RunEnded conduct(CoordinatorOptions job, std::vector<NodeHandle> nodes, Caller& caller, const std::stop_token& stop);

  const std::uint32_t threads;
  const std::unique_ptr<Membership> seat;  // null: no cluster
  EngineConfig config;
  std::shared_ptr<AllShares> source;
  std::shared_ptr<std::atomic<std::uint64_t>> used = std::make_shared<std::atomic<std::uint64_t>>();
  const std::shared_ptr<NodeMeter> meter = std::make_shared<NodeMeter>();
  Prepared<Leave> leave;
  caf::actor_system system;
  NodeHandle node;
  std::atomic<std::uint64_t> jobs{0};
};

namespace {

std::string mebibytes(std::uint64_t bytes) { return std::to_string((bytes >> 20) + 1) + " MiB"; }

}  // namespace

Result<std::vector<NodeHandle>> Engine::Impl::prepare(CoordinatorOptions& job, const std::stop_token& stop) {
  job.job = JobId{++jobs};
  const std::filesystem::path run = job.spec.run_folder;
  BOOST_OUTCOME_TRY(first, first_stage(run, job.stages));
  job.spec.table.stage = first;
  job.mark_settled = [run, lock = std::filesystem::path(job.spec.lock_file)](std::uint32_t stage, bool settled) {
    return mark_settled(run, stage, lock, settled);
  };
  if (!seat) {
    job.weight_max = {};
    return std::vector<NodeHandle>{node};
  }
  BOOST_OUTCOME_TRY(identity, identity_of(run));
  BOOST_OUTCOME_TRY(term, claim_term(run));
  job.job = identity;
  job.term = term;
  job.take_over = true;
  job.replaced = [run, term] { return is_replaced(run, term); };
  job.is_settled = [run](std::uint32_t stage) -> Result<bool> {
    BOOST_OUTCOME_TRY(settled, settled_stages(run, stage + 1));
    return settled > stage;
  };
  job.first_stage = [run, stages = job.stages] { return first_stage(run, stages); };
  job.spec.shares = seat->options().jobs_at_once;
  job.spec.grace_s = seat->options().grace_s;
  job.spec.resumable = false;  // only the node that wrote an image can use it
  // Incarnations tell whose files count, and the next coordinator has another lock.
  job.spec.lock_file.clear();
  auto nodes = seat->nodes(term > Term{1}, stop);
  if (nodes.empty()) return error(Errc::interrupted, "interrupted");
  return nodes;
}

template <class Caller>
RunEnded Engine::Impl::conduct(CoordinatorOptions job, std::vector<NodeHandle> nodes, Caller& caller,
                               const std::stop_token& stop) {
  Prepared<Cancel> prepared_cancel;
  const auto coordinator = system.spawn<Coordinator>(std::move(job), caller, std::move(nodes));
  if (seat) seat->follow(coordinator);
  const std::stop_callback cancel(stop, [&] { prepared_cancel.say(coordinator); });
  return caller.wait();
}

namespace {

// Lends an object to the shares of a job. When the last share has let go of it, nothing works for the job any more.
template <class Held>
struct Lent {
  // Shared, because the last share may still use the promise when this object is gone.
  explicit Lent(const Held& held)
      : promise(std::make_shared<std::promise<void>>()),
        gone(promise->get_future()),
        lent(&held, [told = promise](const Held*) { told->set_value(); }) {}
  std::shared_ptr<std::promise<void>> promise;
  std::future<void> gone;
  std::shared_ptr<const Held> lent;
};

// Takes back what was lent, also when there is no coordinator because of an exception.
template <class TakeBack>
class AtEnd {
 public:
  explicit AtEnd(TakeBack take_back) : take_back_(std::move(take_back)) {}
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;
  ~AtEnd() { take_back_(); }

 private:
  TakeBack take_back_;
};

}  // namespace

Result<RunSummary> Engine::Impl::run(const RoutedCloud& run, const std::filesystem::path& out,
                                     const RunOptions& options, Progress& progress, const std::stop_token& stop,
                                     bool& again) {
  progress.tiles_total = static_cast<std::uint32_t>(
      std::count_if(run.tile_points.begin(), run.tile_points.end(), [](auto n) { return n > 0; }));
  progress.phase = phase_of(ProgramKind::delaunay, StageStep::begin);

  CoordinatorOptions job;
  job.spec = spec_of(options, run.folder.string(), out.string());
  job.weights = run.tile_points;
  for (std::uint32_t t = 0; t < run.tile_points.size(); ++t) {
    if (run.tile_points[t] > 0) job.order.push_back(TileId{t});
  }
  // Tiles of one node are to be near each other, so that most neighbours are on the same node.
  const HilbertKey key_of(run.bounds, run.dimension);
  std::vector<std::uint64_t> keys(run.tile_points.size());
  for (const TileId t : job.order) {
    const Bounds& b = run.tile_bounds[t.value];
    keys[t.value] = key_of({b.lo.x / 2 + b.hi.x / 2, b.lo.y / 2 + b.hi.y / 2, b.lo.z / 2 + b.hi.z / 2});
  }
  std::stable_sort(job.order.begin(), job.order.end(),
                   [&](TileId a, TileId b) { return keys[a.value] < keys[b.value]; });
  job.stored = [out](std::uint32_t) { return receipts_of(out, [](TileId) { return true; }); };
  job.weight_max = [dimension = run.dimension, kernel = options.kernel](std::uint32_t own, std::uint64_t bytes) {
    return budget::tile_points_max(dimension, kernel, own, bytes);
  };
  job.tile_in_words = [dimension = run.dimension, kernel = options.kernel](std::uint64_t points) {
    return "a tile of " + std::to_string(points) + " points, which needs about " +
           mebibytes(budget::tile_working_bytes(dimension, kernel, points));
  };
  BOOST_OUTCOME_TRY(nodes, prepare(job, stop));

  RunCaller caller(progress);
  RunEnded end;
  Lent lent(run);
  {
    source->clouds.offer(std::move(lent.lent), options.taker);
    const AtEnd withdraw([&] { source->clouds.withdraw(run); });
    end = conduct(std::move(job), std::move(nodes), caller, stop);
  }
  lent.gone.wait();
  again = end.again;
  if (end.failure) return error_of(std::move(end.failure));
  return caller.summary(end);
}

Status Engine::Impl::run(const ResultJob& wanted, const std::function<void(double)>& fraction, Progress& progress,
                         const std::stop_token& stop, bool& again) {
  BOOST_OUTCOME_TRY(stages, source->results.kind(wanted.kind));
  BOOST_OUTCOME_TRY(result, TileSource::open(wanted.result));
  CoordinatorOptions job;
  static_cast<ShareOptions&>(job.spec) = wanted.options;
  job.spec.run_folder = wanted.run.string();
  job.spec.out_folder = wanted.result.string();
  job.spec.stages = wanted.kind;
  job.stages = stages->count();
  BOOST_OUTCOME_TRY(plan, read_whole(plan_file(wanted.run)));
  BOOST_OUTCOME_TRY(weights, stages->weights(result, wanted.run, plan));
  for (std::uint32_t t = 0; t < weights.size(); ++t) {
    if (weights[t] > 0) job.order.push_back(TileId{t});
  }
  job.weights = std::move(weights);
  job.stored = [stages = stages, run = wanted.run](std::uint32_t stage) { return stages->stored(run, stage); };
  const std::uint64_t of_point = bytes_a_point(*stages, result);
  // Half of a node's memory is for tiles that are worked on.
  job.weight_max = [of_point](std::uint32_t, std::uint64_t bytes) { return bytes / 2 / of_point; };
  job.tile_in_words = [of_point](std::uint64_t points) {
    return "a tile of " + std::to_string(points) + " points, which needs about " + mebibytes(points * of_point);
  };
  BOOST_OUTCOME_TRY(nodes, prepare(job, stop));

  StagesCaller caller(job.spec.table.stage, job.stages, job.order.size(), fraction, progress);
  RunEnded end;
  Lent lent(wanted);
  {
    source->results.offer(wanted.run, std::move(lent.lent));
    const AtEnd withdraw([&] { source->results.withdraw(wanted.run); });
    end = conduct(std::move(job), std::move(nodes), caller, stop);
  }
  lent.gone.wait();
  again = end.again;
  if (end.failure) return error_of(std::move(end.failure));
  return success();
}

Engine::Engine(std::uint32_t threads, std::uint64_t memory_bytes, KindsOfStages kinds)
    : impl_(std::make_unique<Impl>(threads, memory_bytes, nullptr, std::move(kinds))) {}

Engine::Engine(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Engine>> Engine::join(std::uint32_t threads, std::uint64_t memory_bytes,
                                             std::unique_ptr<Membership> membership, KindsOfStages kinds) {
  auto impl = std::make_unique<Impl>(threads, memory_bytes, std::move(membership), std::move(kinds));
  Membership::Own own;
  own.node = caf::actor_cast<caf::actor>(impl->node);
  own.threads = threads;
  own.memory_bytes = memory_bytes;
  own.memory_used = [used = impl->used] { return used->load(); };
  own.jobs = [meter = impl->meter] { return meter->now().shares; };
  BOOST_OUTCOME_TRYV(impl->seat->take(impl->system, own));
  return std::unique_ptr<Engine>(new Engine(std::move(impl)));
}

Engine::~Engine() = default;

Result<RunSummary> Engine::run(const RoutedCloud& run, const std::filesystem::path& out, const RunOptions& options,
                               Progress& progress, std::stop_token stop) {
  bool again = false;
  auto summary = impl_->run(run, out, options, progress, stop, again);
  // Once only: where damage follows damage, the job must not go on.
  if (again) summary = impl_->run(run, out, options, progress, stop, again);
  return summary;
}

Status Engine::run(const ResultJob& job, const std::function<void(double)>& fraction, Progress& progress,
                   std::stop_token stop) {
  bool again = false;
  Status ended = impl_->run(job, fraction, progress, stop, again);
  if (again) ended = impl_->run(job, fraction, progress, stop, again);
  if (ended && fraction) fraction(1);
  return ended;
}

std::unique_ptr<SplitRouter> Engine::router(std::uint64_t memory_bytes) const {
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

MembershipStatus Engine::membership_status() const { return impl_->seat->membership_status(); }

void Engine::depart() const { impl_->seat->depart(); }

bool Engine::gathering() const { return impl_->seat && impl_->seat->gathering(); }

std::vector<NodeState> Engine::nodes() const { return impl_->seat->members(); }

std::uint64_t Engine::nodes_lost() const { return impl_->seat->lost(); }

Result<bool> Engine::drain(const std::string& node) const { return impl_->seat->drain(node); }

}  // namespace tessera

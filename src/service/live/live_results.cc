#include "src/service/live/live_results.h"

#include <exception>
#include <optional>
#include <utility>

#include "src/base/thread_name.h"
#include "src/service/live/points_body.h"
#include "src/service/problem.h"
#include "src/service/results/owners.h"

namespace tessera::service {
namespace {

// Callers know the result by its name.
Error with_name(Error failed, const std::string& folder, std::string_view name) {
  const std::string called = "triangulation '" + std::string(name) + "'";
  std::string& said = failed.where;
  for (std::size_t at = said.find(folder); at != std::string::npos; at = said.find(folder, at + called.size()))
    said.replace(at, folder.size(), called);
  return failed;
}

}  // namespace

void LiveResults::open(const std::function<std::string(const std::string& name)>& busy) {
  for (const std::string& name : options_.names) {
    if (live_.contains(name)) continue;
    KeptLiveOptions kept{
        .live = {.threads = options_.threads, .memory_bytes = options_.memory_bytes / options_.names.size()},
        .log_bytes_max = options_.log_bytes_max,
        .grown = [this, name] {
          const std::lock_guard lock(mutex_);
          due_.insert(name);
          grown_.notify_all();
        }};
    auto opened = [&]() -> Result<std::unique_ptr<KeptLive>> {
      BOOST_OUTCOME_TRY(there, folders_.exists(name));
      if (!there) return error(Errc::usage, "there is no triangulation '" + name + "'");
      if (const std::string job = busy(name); !job.empty())
        return error(Errc::usage,
                     "job " + job + " is going to change it; start the daemon again when that job has ended");
      return KeptLive::open(folders_.folder(name), std::move(kept));
    }();
    if (!opened) {
      refused_[name] = with_name(opened.error(), folders_.folder(name).string(), name).where;
      warn("triangulation '" + name + "' is not live: " + opened.error().where);
      continue;
    }
    const auto version = opened.value()->current();
    if (options_.note)
      options_.note("triangulation '" + name + "' is live, with " + std::to_string(version->vertices()) +
                    " vertices in version " + std::to_string(version->number()));
    live_[name] = std::move(opened).value();
  }
  if (!live_.empty()) storer_ = std::jthread([this](const std::stop_token& stop) { store_what_grows(stop); });
}

LiveResults::~LiveResults() {
  if (storer_.joinable()) {
    storer_.request_stop();
    storer_.join();
  }
  for (const auto& [name, live] : live_) store(name, *live);
}

void LiveResults::store_what_grows(const std::stop_token& stop) {
  name_thread("live");
  while (true) {
    std::set<std::string> due;
    {
      std::unique_lock lock(mutex_);
      grown_.wait(lock, stop, [&] { return !due_.empty(); });
      if (stop.stop_requested()) return;
      due.swap(due_);
    }
    for (const std::string& name : due) {
      KeptLive& live = *live_.at(name);
      if (live.should_store()) store(name, live);
    }
  }
}

void LiveResults::store(const std::string& name, KeptLive& live) {
  const Status stored = [&]() -> Status {
    try {
      return live.store();
    } catch (const std::exception& thrown) {
      return error(Errc::internal, thrown.what());
    }
  }();
  if (!stored)
    warn("triangulation '" + name + "' was not stored, and its changes stay in the log: " + stored.error().where);
}

KeptLive* LiveResults::find(std::string_view name) const {
  const auto found = live_.find(name);
  return found == live_.end() ? nullptr : found->second.get();
}

Reply<KeptLive*> LiveResults::find_or_refuse(std::string_view name) const {
  if (KeptLive* live = find(name)) return live;
  const auto there = folders_.exists(name);
  if (!there) return problem_of(there.error());
  const std::string called = "triangulation '" + std::string(name) + "'";
  if (!there.value()) return problem(404, "there is no " + called, Errc::usage);
  const auto why = refused_.find(name);
  return problem(409,
                 called + " is not live, so points can be neither added nor removed" +
                     (why == refused_.end() ? "; the daemon keeps only those results in memory that it was told to"
                                            : ": " + why->second),
                 Errc::usage);
}

Reply<KeptLive*> LiveResults::find_to_change(std::string_view name, const Caller& caller) const {
  BOOST_OUTCOME_TRY(live, find_or_refuse(name));
  const auto owner = owner_of_(std::string(name));
  if (!owner) return problem_of(owner.error());
  if (may_remove(owner.value(), caller)) return live;
  return problem(403, "triangulation '" + std::string(name) + "': only its owner or an admin may change it",
                 Errc::usage);
}

Reply<proto::PointsChanged> LiveResults::apply(KeptLive& live, std::string_view name,
                                               const Result<ResultChange>& change, EqualToNew equal,
                                               const Caller& caller) {
  const auto applied = [&]() -> Result<proto::PointsChanged> {
    BOOST_OUTCOME_TRYV(change);
    return live.change(change.value(), equal, caller.stop);
  }();
  if (applied) return applied.value();
  return problem_of(with_name(applied.error(), folders_.folder(name).string(), name));
}

Reply<proto::PointsChanged> LiveResults::add(std::string_view name, const PointsBody& points, const Caller& caller) {
  BOOST_OUTCOME_TRY(live, find_to_change(name, caller));
  const EqualToNew equal = points.replace ? EqualToNew::go : EqualToNew::stay;
  return apply(*live, name, read_points_body(points, live->manifest()), equal, caller);
}

Reply<proto::PointsChanged> LiveResults::remove(std::string_view name, const PointsBody& ids, const Caller& caller) {
  BOOST_OUTCOME_TRY(live, find_to_change(name, caller));
  const auto change = [&]() -> Result<ResultChange> {
    BOOST_OUTCOME_TRY(read, read_ids_body(ids));
    return ResultChange{.remove = std::move(read)};
  }();
  return apply(*live, name, change, EqualToNew::stay, caller);
}

Reply<std::unique_ptr<Subscription>> LiveResults::follow(std::string_view name, std::optional<std::uint64_t> last,
                                                         OnVersion on_event) {
  BOOST_OUTCOME_TRY(live, find_or_refuse(name));
  return live->events().follow(last, std::move(on_event));
}

std::optional<proto::LiveInfo> LiveResults::live(std::string_view name) const {
  const KeptLive* kept = find(name);
  if (!kept) return std::nullopt;
  const LiveState state = kept->state();
  proto::LiveInfo info;
  info.set_version(state.version);
  info.set_stored_version(state.stored);
  info.set_vertices(kept->current()->vertices());
  info.set_points_added(state.added);
  info.set_points_removed(state.removed);
  if (state.broken) info.set_problem(with_name(*state.broken, folders_.folder(name).string(), name).where);
  return info;
}

}  // namespace tessera::service

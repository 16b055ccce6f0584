#include "actors/engine/cluster_router.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "actors/failing.h"
#include "actors/prepared.h"
#include "actors/router.h"
#include "src/delaunay/run/routing.h"

namespace tessera {
namespace {

// Passes what the router's actor says to the thread that waits in route().
class LocalSplitQueue final : public RoutingOwner {
 public:
  struct Here {
    std::uint32_t split = 0, attempt = 0;
    std::string why;
  };
  struct End {
    std::vector<std::uint32_t> attempts;
    Failure failure;
  };

  explicit LocalSplitQueue(Progress& progress) : progress_(progress) {}

  void progressed(std::uint64_t points) override { progress_.points_routed = points; }
  void route_here(std::uint32_t split, std::uint32_t attempt, std::string why) override {
    const std::lock_guard lock(mutex_);
    here_ = {split, attempt, std::move(why)};
    changed_.notify_one();
  }
  void ended(std::vector<std::uint32_t> attempts, Failure failure) noexcept override {
    const std::lock_guard lock(mutex_);
    end_ = {std::move(attempts), std::move(failure)};
    changed_.notify_one();
  }

  // Waits for the next split to route here. Empty: the routing has ended.
  std::optional<Here> next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return here_ || end_; });
    return end_ ? std::nullopt : std::exchange(here_, std::nullopt);
  }
  // Waits for the end of the routing.
  End end() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return end_.has_value(); });
    return std::move(*end_);
  }

 private:
  Progress& progress_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Here> here_;
  std::optional<End> end_;
};

}  // namespace

// Returns the size of a split. Each node gets several splits, so that nodes that are done early take more. A split
// keeps a node busy for a while.
std::uint64_t ClusterRouter::split_points(std::uint64_t total) const {
  const std::uint64_t unknown = 2'000'000;
  const std::uint64_t nodes = std::max<std::size_t>(1, seat_.members().size());
  return total == 0 ? unknown : std::clamp<std::uint64_t>(total / (4 * nodes), 100'000, 8'000'000);
}

Result<std::vector<std::uint32_t>> ClusterRouter::route(const Cloud& cloud, const std::vector<InputSplit>& splits,
                                                        const Partition& partition,
                                                        const std::filesystem::path& run_folder, Progress& progress,
                                                        const std::stop_token& stop) {
  BOOST_OUTCOME_TRYV(write_routing(run_folder, cloud, splits, partition));
  RouterOptions options;
  options.run_folder = std::filesystem::absolute(run_folder).string();
  options.shares = seat_.options().jobs_at_once;
  for (const InputSplit& split : splits) options.here.push_back(split.here);
  const auto nodes = seat_.nodes(false, stop);
  if (nodes.empty()) return error(Errc::interrupted, "interrupted while points were routed");
  LocalSplitQueue queue(progress);
  Prepared<Cancel> cancel, cancel_by_user;
  const auto router = system_.spawn<Router>(std::move(options), queue, nodes);
  // The router refers to `queue` until it has ended, so it is cancelled and waited for, also after an exception.
  struct Ending {
    ~Ending() {
      cancel.say(router);
      queue.end();
    }
    LocalSplitQueue& queue;
    Prepared<Cancel>& cancel;
    const RouterHandle& router;
  } const ending{queue, cancel, router};
  seat_.follow(router);
  {
    const std::stop_callback when_stopped(stop, [&] { cancel_by_user.say(router); });
    while (const auto here = queue.next()) {
      if (!here->why.empty())
        seat_.options().log("a node cannot route an input split, so this process routes it: " + here->why);
      SplitRouted routed;
      routed.attempt = here->attempt;
      routed.done = true;
      const auto tell = [&](std::uint64_t more) { routed.routed += more; };
      const SplitWork work{run_folder, here->attempt, memory_bytes_, tell};
      if (Status done = route_split(cloud, splits[here->split], partition, work, stop); !done)
        routed.failure = failure_of(std::move(done).error());
      caf::anon_send(router, std::move(routed));
    }
  }
  LocalSplitQueue::End end = queue.end();
  if (end.failure) return error_of(std::move(end.failure));
  return std::move(end.attempts);
}

}  // namespace tessera

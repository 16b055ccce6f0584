#include "actors/node_actor.h"

#include <algorithm>
#include <new>
#include <string>
#include <utility>

#include "actors/failing.h"
#include "actors/share_actor.h"
#include "src/base/files/inside.h"
#include "src/delaunay/run/routing.h"

namespace tessera {
namespace {

constexpr std::uint64_t work_between_reports = 500'000;

}  // namespace

NodeActor::NodeActor(caf::actor_config& config, NodeOptions options, std::shared_ptr<ShareSource> source)
    : SteadyActor(config), options_(std::move(options)), source_(std::move(source)) {
  live_at(options_.hooks.home);
}

NodeActor::behavior_type NodeActor::make_behavior() {
  // An answer could not be delivered. Its receiver watches the actors that it needs, so nothing is to be done here.
  set_error_handler([this](caf::scheduled_actor*, caf::error& reason) {
    options_.hooks.tell([&] { return "node: a message came back: " + in_words(reason); });
  });
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { gone(down); });
  return {
      [this](const OpenShare& wanted) { answer(wanted); },
      [this](const FindShare& wanted) { find(wanted); },
      [this](const RouteSplit& wanted) { route(wanted); },
      [this](const Leave&) { leave(); },
  };
}

// A job that cannot be opened is no reason to lose the others, but a coordinator without an answer waits for ever. The
// memory for the first answer is there from the start. For a later answer there is memory again when another job ends,
// at the latest.
void NodeActor::answer(const OpenShare& wanted) {
  const auto coordinator = caf::actor_cast<CoordinatorHandle>(wanted.coordinator);
  while (answer_.said()) prepare_answer();
  answer_.message() = open_or_say_why(wanted);
  answer_.message().node = wanted.node;
  answer_.message().name = options_.name;
  answer_.say(coordinator);
  prepare_answer();
}

void NodeActor::prepare_answer() noexcept {
  try {
    answer_ = {};
  } catch (const std::bad_alloc&) {  // the old message stays, and counts as said
  }
}

ShareOpened NodeActor::open_or_say_why(const OpenShare& wanted) noexcept {
  ShareOpened answer;
  try {
    auto opened = open(wanted);
    if (opened) return std::move(opened).value();
    answer.failure = failure_of(std::move(opened).error());
  } catch (...) {
    answer.failure = failure_of(std::current_exception(), [] { return std::string("opening a job"); });
  }
  return answer;
}

Result<ShareOpened> NodeActor::open(const OpenShare& wanted) {
  BOOST_OUTCOME_TRY(spec, spec_from_bytes(wanted.spec.get()));
  BOOST_OUTCOME_TRYV(check_path(spec.run_folder));
  BOOST_OUTCOME_TRYV(check_path(spec.out_folder));
  if (is_replaced(wanted.job, wanted.term)) return error(Errc::interrupted, "another coordinator has taken over");
  if (spec.shares > 0) {
    spec.threads = std::max(1U, options_.threads / spec.shares);
    spec.memory_bytes = options_.memory_bytes / spec.shares;
  }
  const std::uint64_t memory = spec.memory_bytes, left = options_.memory_bytes - *options_.used;
  if (memory > left) {
    return error(Errc::memory, "job " + std::to_string(wanted.job.value) + " wants " + std::to_string(memory >> 20) +
                                   " MiB of memory, but the node has " + std::to_string(left >> 20) + " MiB left");
  }
  BOOST_OUTCOME_TRY(made, source_->open(spec, wanted.node));
  *options_.used += memory;
  // Before the share's last reference is gone: the caller that has waited for that may begin the next job.
  const std::shared_ptr<const Share> share(made.release(), [used = options_.used, memory](const Share* last) {
    *used -= memory;
    delete last;
  });
  ShareOpened opened;
  opened.settled = share->settled;
  opened.threads = share->stages.at(share->table->stage).schedule.threads;
  opened.memory_bytes = memory;
  Opened& known = shares_[wanted.job];
  // Last, because nothing may fail once the actor is there.
  const ShareHandle handle =
      spawn<ShareActor>(wanted.node, ShareOptions(spec), share, caf::actor_cast<CoordinatorHandle>(wanted.coordinator),
                        wanted.term, options_.hooks, options_.progress_interval, options_.meter);
  opened.share = caf::actor_cast<caf::actor>(handle);
  known.share = opened.share.address();
  monitor(known.share);
  return opened;
}

// Any process with a certificate of the cluster may send this, not only the coordinator.
Status NodeActor::check_path(const std::string& path) const {
  return options_.data.empty() ? success() : check_inside(options_.data, path);
}

// Terms are kept only for jobs that may have several coordinators.
bool NodeActor::is_replaced(JobId job, Term term) {
  const auto known = terms_.find(job);
  if (known != terms_.end() && term < known->second) return true;
  if (term > Term{}) terms_[job] = term;
  return false;
}

void NodeActor::leave() {
  for (const auto& [job, opened] : shares_) {
    if (const auto share = caf::actor_cast<caf::actor>(opened.share))
      send(caf::actor_cast<ShareHandle>(share), Leave{});
  }
  routing_.clear();
  quit();
}

void NodeActor::find(const FindShare& wanted) {
  // That coordinator will open the job anew, and hear why it cannot.
  if (is_replaced(wanted.job, wanted.term)) return answer_none(wanted);
  const auto found = shares_.find(wanted.job);
  const auto share = found == shares_.end() ? caf::actor{} : caf::actor_cast<caf::actor>(found->second.share);
  if (!share) return answer_none(wanted);
  found->second.wanted = wanted;
  found->second.wanted->name = options_.name;
  send(caf::actor_cast<ShareHandle>(share), *found->second.wanted);
}

void NodeActor::answer_none(const FindShare& wanted) {
  ShareFound none;
  none.term = wanted.term;
  none.node = caf::actor_cast<caf::actor>(this);
  const std::uint32_t shares = std::max(1U, wanted.shares);
  none.threads = std::max(1U, options_.threads / shares);
  none.memory_bytes = options_.memory_bytes / shares;
  none.name = options_.name;
  send(caf::actor_cast<CoordinatorHandle>(wanted.coordinator), std::move(none));
}

// A router that is told that a split is done may send the next one at once. So the assignment below waits for the
// thread of the split before.
void NodeActor::route(const RouteSplit& wanted) {
  std::erase_if(routing_, [](auto& entry) { return entry.second.get_stop_token().stop_requested(); });
  const auto router = caf::actor_cast<RouterHandle>(wanted.router);
  SplitWork work{wanted.run_folder, wanted.attempt, options_.memory_bytes / std::max(1U, wanted.shares), {}};
  const auto threads = std::max(1U, options_.threads / std::max(1U, wanted.shares));
  monitor(wanted.router);
  routing_[wanted.router.address()] =
      std::jthread([router, work, threads, split = wanted.split,
                    allowed = check_path(wanted.run_folder)](const std::stop_token& stop) mutable {
        SplitRouted routed;
        routed.attempt = work.attempt;
        std::uint64_t told = 0;
        work.routed = [&](std::uint64_t more) {
          routed.routed += more;
          if (routed.routed - told < work_between_reports) return;
          told = routed.routed;
          caf::anon_send(router, routed);
        };
        try {
          if (!allowed) {
            routed.failure = failure_of(allowed.error());
          } else if (Status done = route_split(work.run_folder, split, threads, work, stop); !done)
            routed.failure = failure_of(std::move(done).error());
        } catch (...) {
          routed.failure = failure_of(std::current_exception(), [] { return std::string("routing input"); });
        }
        routed.done = true;
        caf::anon_send(router, std::move(routed));
      });
}

// If the share has not answered a coordinator that takes over, this actor must do so now.
void NodeActor::gone(const caf::down_msg& down) {
  if (const auto routing = routing_.find(down.source); routing != routing_.end()) routing->second.request_stop();
  const auto found = std::find_if(shares_.begin(), shares_.end(),
                                  [&](const auto& entry) { return entry.second.share == down.source; });
  if (found == shares_.end()) return;
  if (found->second.wanted) answer_none(*found->second.wanted);
  shares_.erase(found);
}

}  // namespace tessera

#include "actors/cluster/registry.h"

#include <algorithm>
#include <utility>

#include "actors/cluster/handshakes.h"
#include "actors/cluster/network.h"
#include "actors/failing.h"

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::hours refused_again{1};
constexpr std::size_t refused_max = 256;  // lines: a refused process can change its name each time

std::string known_as(const MemberInfo& info) { return "node " + info.name + " (" + info.address + ")"; }

}  // namespace

Registry::Registry(caf::actor_config& config, ClusterOptions options)
    : SteadyActor(config), options_(std::move(options)), members_(options_.lease) {}

void Registry::on_exit() {
  actors_.clear();
  jobs_.clear();
}

void Registry::failed(const std::exception_ptr& exception) noexcept {
  options_.log(failure_of(exception, [] { return std::string("the cluster's coordinator"); }).text);
  options_.expelled("the cluster's coordinator ended unexpectedly", true);
}

Registry::behavior_type Registry::make_behavior() {
  // Receivers that are gone are noticed by the monitors.
  set_error_handler([](caf::scheduled_actor*, caf::error&) {});
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { gone(down); });
  delayed_send(this, options_.lease / 10, caf::tick_atom::value);
  return {
      [this](const WhoIs& who) {
        send(caf::actor_cast<MemberHandle>(who.asks), CoordinatorIs{caf::actor_cast<caf::actor>(this), {}});
      },
      [this](const Hello& hello) { welcome(hello); },
      [this](const ReachedAll& reached) {
        if (!members_.mark_reached_all(reached.uuid) || leaving_.contains(reached.uuid)) return;
        const Actors& actors = actors_.at(reached.uuid);
        options_.log(known_as(members_.find(reached.uuid)->info) + " has joined");
        for (const FollowerHandle& job : jobs_) send(job, NodeJoined{actors.node});
      },
      [this](const Renew& renew) {
        const bool member = members_.renew(renew.uuid, renew.use, Clock::now());
        if (member) send(actors_.at(renew.uuid).member, Renewed{});
      },
      [this](const Unreachable& pair) { members_.note_unreachable(pair.from, pair.to, Clock::now()); },
      [this](const Leaving& leaving) { hear(leaving); },
      [this](const Follow& job) { follow(job.follower); },
      [this](const Drain& wanted) { return drain(wanted.node); },
      [this](const NodeLet& let_go) {
        for (const auto& [uuid, actors] : actors_) {
          if (actors.node == let_go.node) return let(caf::actor_cast<FollowerHandle>(let_go.follower), NodeUuid(uuid));
        }
      },
      [this](const AskMembers&) { return list(); },
      [this](const Leave&) { quit(); },
      [this](caf::tick_atom) { tick(); },
  };
}

std::string Registry::refusal(const Hello& hello) const {
  if (hello.wire != wire_version) {
    return "its messages between nodes have version " + std::to_string(hello.wire) +
           ", those of the coordinator version " + std::to_string(wire_version) +
           ": install the same release on all nodes";
  }
  if (hello.cluster != options_.name)
    return "it belongs to the cluster '" + hello.cluster + "', the coordinator to '" + options_.name + "'";
  if (hello.shared != options_.shared)
    return "its data folder is not the coordinator's: nodes of a cluster share one folder";
  return {};
}

// A refused node asks again twice a second until it is repaired. So each line is logged once an hour.
void Registry::tell_refused(const std::string& line) {
  const auto now = Clock::now();
  std::erase_if(refused_, [&](const auto& entry) { return now - entry.second >= refused_again; });
  if (refused_.size() < refused_max && refused_.try_emplace(line, now).second) options_.log(line);
}

void Registry::welcome(const Hello& hello) {
  const auto member = caf::actor_cast<MemberHandle>(hello.member);
  const std::string refused = refusal(hello);
  if (!refused.empty()) {
    tell_refused(known_as(hello.info) + " is refused: " + refused);
    return send(member, Refused{refused});
  }
  if (!members_.hello(hello.info, hello.use, Clock::now())) return send(member, Expelled{"was lost", true});
  if (actors_.emplace(hello.info.uuid, Actors{member, hello.node, hello.last_words}).second) {
    monitor(member);
    if (!hello.last_words.empty()) {
      options_.log(known_as(hello.info) + " is back; the process before it " + hello.last_words);
      for (const FollowerHandle& job : jobs_) send(job, NodeBack{hello.info.name, hello.last_words});
    }
  }
  Welcome welcome;
  welcome.coordinator = to_string(options_.advertised);
  for (const auto& [uuid, other] : members_.all()) {
    if (uuid == hello.info.uuid) continue;
    welcome.uuids.push_back(uuid);
    welcome.addresses.push_back(other.info.address);
  }
  send(member, std::move(welcome));
}

void Registry::lose(const Members::Loss& loss, bool again) {
  if (again) ++lost_;
  options_.log(known_as(loss.member.info) + (again ? " is lost: it " + loss.why : " " + loss.why));
  const auto found = actors_.find(loss.member.info.uuid);
  if (found == actors_.end()) return;
  const Actors actors = found->second;
  actors_.erase(found);
  leaving_.erase(loss.member.info.uuid);
  demonitor(actors.member.address());
  for (const FollowerHandle& job : jobs_) send(job, NodeLost{actors.node, loss.why});
  send(actors.member, Expelled{loss.why, again});
}

void Registry::follow(const caf::actor& job) {
  const auto follower = caf::actor_cast<FollowerHandle>(job);
  if (!jobs_.insert(follower).second) return;
  monitor(follower);
  for (const auto& [uuid, member] : members_.all()) {
    if (leaving_.contains(uuid)) {
      ask_to_let(uuid, follower);  // the job may have begun with this node
    } else if (member.free) {
      send(follower, NodeJoined{actors_.at(uuid).node});
    }
  }
}

Drained Registry::drain(const std::string& node) {
  const auto& all = members_.all();
  const auto wanted = std::find_if(
      all.begin(), all.end(), [&](const auto& entry) { return entry.first == node || entry.second.info.name == node; });
  if (wanted == all.end()) return {};
  const bool other = std::any_of(all.begin(), all.end(), [&](const auto& entry) {
    return entry.first != wanted->first && entry.second.free && !leaving_.contains(entry.first);
  });
  if (!other) return {true, "it is the only node that is free for work: start another node first"};
  begin_leaving(NodeUuid(wanted->first));
  return {true, {}};
}

// The node remembers that it is to leave, and tells the next coordinator. The node stays until it has said that it
// works for no job, because jobs of an earlier coordinator may be still to come, and have begun tiles there.
void Registry::begin_leaving(const NodeUuid& uuid) {
  if (!leaving_.try_emplace(uuid).second) return;
  options_.log(known_as(members_.find(uuid)->info) + " leaves: its tiles go to other nodes");
  for (const FollowerHandle& job : std::set(jobs_)) ask_to_let(uuid, job);
  send(actors_.at(uuid).member, AskToLeave{});
}

void Registry::hear(const Leaving& leaving) {
  if (!members_.find(leaving.uuid)) return;
  begin_leaving(leaving.uuid);
  leaving_[leaving.uuid].at_work = leaving.jobs > 0;
  let_if_over(leaving.uuid);
}

void Registry::ask_to_let(const NodeUuid& uuid, const FollowerHandle& job) {
  leaving_[uuid].jobs.insert(job);
  send(job, NodeLeaves{actors_.at(uuid).node, caf::actor_cast<caf::actor>(this)});
}

// `job` has nothing on that node any more, or has ended.
void Registry::let(const FollowerHandle& job, const NodeUuid& uuid) {
  const auto leaving = leaving_.find(uuid);
  if (leaving == leaving_.end()) return;
  leaving->second.jobs.erase(job);
  if (leaving->second.jobs.empty() && leaving->second.at_work) return send(actors_.at(uuid).member, AskToLeave{});
  let_if_over(uuid);
}

void Registry::let_if_over(const NodeUuid& uuid) {
  const Going& going = leaving_.at(uuid);
  if (!going.jobs.empty() || going.at_work) return;
  if (const auto loss = members_.lose(uuid, "is drained")) lose(*loss, false);
}

void Registry::gone(const caf::down_msg& down) {
  for (const FollowerHandle& job : std::set(jobs_)) {
    if (job.address() != down.source) continue;
    jobs_.erase(job);
    std::vector<NodeUuid> leaving;
    for (const auto& [uuid, jobs] : leaving_) leaving.push_back(uuid);
    for (const NodeUuid& uuid : leaving) let(job, uuid);
  }
  const auto found = std::find_if(actors_.begin(), actors_.end(),
                                  [&](const auto& entry) { return entry.second.member.address() == down.source; });
  if (found == actors_.end()) return;
  if (const auto loss = members_.lose(NodeUuid(found->first), "does not answer any more")) lose(*loss);
}

void Registry::tick() {
  if (const auto closed = close_mute_connections(options_.lease); closed > 0)
    options_.log(std::to_string(closed) + " connections were closed because no message came over them");
  for (const std::string& trouble : take_handshake_troubles()) options_.log(trouble);
  delayed_send(this, options_.lease / 10, caf::tick_atom::value);
  for (const Members::Loss& loss : members_.lose_silent(Clock::now())) lose(loss);
}

MemberList Registry::list() const {
  MemberList out;
  out.lost = lost_;
  std::vector<std::pair<std::uint64_t, NodeUuid>> by_number;
  for (const auto& [uuid, member] : members_.all()) by_number.emplace_back(member.number, uuid);
  std::sort(by_number.begin(), by_number.end());
  const auto now = Clock::now();
  const auto since = [&](auto unit, Members::Time time) {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<decltype(unit)>(now - time).count());
  };
  for (const auto& [number, uuid] : by_number) {
    const Members::Member& member = *members_.find(uuid);
    out.members.push_back({member.info, false, member.free && !leaving_.contains(uuid), leaving_.contains(uuid),
                           actors_.at(uuid).last_words, since(std::chrono::seconds(), member.came),
                           since(std::chrono::milliseconds(), member.heard), member.use});
    out.nodes.push_back(actors_.at(uuid).node);
  }
  return out;
}

}  // namespace tessera

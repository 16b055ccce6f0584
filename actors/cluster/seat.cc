#include "actors/cluster/seat.h"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "actors/cluster/member.h"
#include "actors/cluster/network.h"
#include "actors/cluster/registry.h"
#include "src/base/files/free_space.h"
#include "src/base/random_token.h"

namespace tessera {
namespace {

caf::actor as_actor(const auto& handle) { return caf::actor_cast<caf::actor>(handle); }

}  // namespace

void Seat::prepare(caf::actor_system_config& config) {
  config.add_message_types<caf::id_block::tessera_cluster>();
  load_network(config, options_);
}

Status Seat::take(caf::actor_system& system, const Own& own) {
  system_ = &system;
  ClusterOptions& o = options_;
  if (o.listen.port == 0) return error(Errc::usage, "the cluster's address needs a port");
  if (o.advertised.host.empty()) o.advertised.host = o.listen.host;
  if (o.advertised.port == 0) o.advertised.port = o.listen.port;
  // A coordinator goes on when its process is no node any more. Then nothing of the node may hold on to a job.
  o.expelled = [told = std::move(o.expelled), node = own.node ? own.node.address() : caf::actor_addr()](
                   const std::string& why, bool again) {
    if (const auto there = caf::actor_cast<caf::actor>(node))
      caf::anon_send(caf::actor_cast<NodeHandle>(there), Leave{});
    told(why, again);
  };
  const auto open = [&](const caf::actor& door) -> Status {
    BOOST_OUTCOME_TRY(port, publish(door, o.listen));
    port_ = port;
    return success();
  };
  if (o.coordinator) {
    registry_ = system.spawn<Registry>(o);
    BOOST_OUTCOME_TRYV(open(as_actor(registry_)));
  }
  if (o.node) {
    MemberOptions member;
    member.cluster = o;
    uuid_ = random_token() + random_token();
    member.info = {uuid_, o.node_name, to_string(o.advertised), own.threads, own.memory_bytes, o.certificate_end_s};
    member.last_words = last_words_;
    member.registry = as_actor(registry_);
    member.node = own.node;
    member.use = [used = own.memory_used, scratch = o.scratch] { return NodeUse{used(), free_bytes(scratch)}; };
    member.jobs = own.jobs;
    member_ = system.spawn<Member>(std::move(member));
    if (!o.coordinator) {
      BOOST_OUTCOME_TRYV(open(as_actor(member_)));
    }
  }
  return success();
}

void Seat::leave() noexcept {
  if (!system_) return;
  if (port_ != 0) unpublish(*system_, registry_ ? as_actor(registry_) : as_actor(member_), port_);
  if (member_) caf::anon_send(member_, Leave{});
  if (registry_) caf::anon_send(registry_, Leave{});
  member_ = nullptr;
  registry_ = nullptr;
}

MemberList Seat::list() const {
  caf::scoped_actor self{*system_, true};
  MemberList list;
  self->request(registry_, caf::infinite, AskMembers{})
      // On an error the registry is ending: there are no members.
      .receive([&](MemberList& answer) { list = std::move(answer); }, [](const caf::error&) {});
  return list;
}

MembershipStatus Seat::membership_status() const {
  caf::scoped_actor self{*system_, true};
  MembershipStatus status;
  status.trouble = "leaves the cluster";
  self->request(member_, caf::infinite, AskStatus{})
      // On an error the member is ending.
      .receive([&](MembershipStatus& answer) { status = std::move(answer); }, [](const caf::error&) {});
  return status;
}

void Seat::depart() const { caf::anon_send(member_, AskToLeave{}); }

std::vector<NodeState> Seat::members() const {
  auto members = list().members;
  for (NodeState& member : members) member.own = member.info.uuid == uuid_;
  return members;
}

bool Seat::gathering() const { return registry_ && std::chrono::steady_clock::now() - taken_ < options_.lease; }

std::vector<NodeHandle> Seat::nodes(bool all, const std::stop_token& stop) const {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  while (!stop.stop_requested()) {
    std::vector<NodeHandle> nodes;
    const MemberList now = list();
    for (std::size_t i = 0; i < now.members.size(); ++i) {
      const bool may_have_shares = all && now.members[i].leaves;
      if (now.members[i].free || may_have_shares) nodes.push_back(caf::actor_cast<NodeHandle>(now.nodes[i]));
    }
    if (!nodes.empty() && !(all && gathering())) return nodes;
    stopped.wait_for(lock, stop, std::chrono::milliseconds(100), [] { return false; });
  }
  return {};
}

void Seat::follow(const FollowerHandle& job) const { caf::anon_send(registry_, Follow{as_actor(job)}); }

Result<bool> Seat::drain(const std::string& node) const {
  caf::scoped_actor self{*system_, true};
  Drained drained;
  self->request(registry_, caf::infinite, Drain{node})
      // On an error the registry is ending: there is no such node.
      .receive([&](Drained& answer) { drained = std::move(answer); }, [](const caf::error&) {});
  if (!drained.refused.empty()) return error(Errc::usage, "node '" + node + "': " + drained.refused);
  return drained.found;
}

}  // namespace tessera

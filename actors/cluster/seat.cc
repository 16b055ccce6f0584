#include "actors/cluster/seat.h"

#include <condition_variable>
#include <mutex>
#include <random>
#include <utility>

#include "actors/cluster/member.h"
#include "actors/cluster/network.h"
#include "actors/cluster/registry.h"

namespace tessera {
namespace {

NodeUuid new_uuid() {
  std::random_device random;
  constexpr char digits[] = "0123456789abcdef";
  NodeUuid uuid;
  for (int i = 0; i < 32; ++i) uuid.push_back(digits[random() % 16]);
  return uuid;
}

caf::actor as_actor(const auto& handle) { return caf::actor_cast<caf::actor>(handle); }

}  // namespace

Result<std::unique_ptr<Seat>> Seat::take(caf::actor_system& system, ClusterOptions options, const Own& own) {
  std::unique_ptr<Seat> seat(new Seat(system, std::move(options)));
  ClusterOptions& o = seat->options_;
  // The port must be known before anybody hears of it: so whoever is published waits for its first message.
  if (o.advertised.host.empty()) o.advertised.host = o.listen.host;
  const auto open = [&](const caf::actor& door) -> Status {
    BOOST_OUTCOME_TRY(port, publish(system, door, o.listen));
    seat->port_ = port;
    return success();
  };
  if (o.listen.port == 0) return error(Errc::usage, "the cluster's address needs a port");
  if (o.advertised.port == 0) o.advertised.port = o.listen.port;
  if (o.coordinator) {
    seat->registry_ = system.spawn<Registry>(o);
    BOOST_OUTCOME_TRYV(open(as_actor(seat->registry_)));
  }
  if (o.node) {
    MemberOptions member;
    member.cluster = o;
    seat->uuid_ = new_uuid();
    member.info = {seat->uuid_, o.node_name, to_string(o.advertised), own.threads, own.memory_bytes};
    member.registry = as_actor(seat->registry_);
    member.node = own.node;
    member.memory_used = own.memory_used;
    seat->member_ = system.spawn<Member>(std::move(member));
    if (!o.coordinator) {
      BOOST_OUTCOME_TRYV(open(as_actor(seat->member_)));
    }
  }
  return seat;
}

Seat::~Seat() {
  const caf::actor door = registry_ ? as_actor(registry_) : as_actor(member_);
  if (port_ != 0) unpublish(system_, door, port_);
  if (member_) caf::anon_send(member_, Leave{});
  if (registry_) caf::anon_send(registry_, Leave{});
}

MemberList Seat::members() const {
  caf::scoped_actor self{system_, true};
  MemberList list;
  self->request(registry_, caf::infinite, AskMembers{})
      .receive([&](MemberList& answer) { list = std::move(answer); }, [](const caf::error&) {});  // it is ending: none
  return list;
}

std::vector<NodeHandle> Seat::nodes(bool gathering, const std::stop_token& stop) const {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  while (!stop.stop_requested()) {
    std::vector<NodeHandle> nodes;
    for (const MemberReport& member : members().members) {
      if (member.free && !member.draining) nodes.push_back(caf::actor_cast<NodeHandle>(member.node));
    }
    const bool in_time = gathering && std::chrono::steady_clock::now() - taken_ < options_.lease;
    if (!nodes.empty() && !in_time) return nodes;
    stopped.wait_for(lock, stop, std::chrono::milliseconds(100), [] { return false; });
  }
  return {};
}

void Seat::follow(const CoordinatorHandle& job) const { caf::anon_send(registry_, Follow{as_actor(job)}); }

Drained Seat::drain(const std::string& node) const {
  caf::scoped_actor self{system_, true};
  Drained drained;
  self->request(registry_, caf::infinite, Drain{node})
      .receive([&](Drained& answer) { drained = std::move(answer); }, [](const caf::error&) {});  // it is ending: none
  return drained;
}

}  // namespace tessera

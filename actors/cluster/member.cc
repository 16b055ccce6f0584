#include "actors/cluster/member.h"

#include <algorithm>
#include <utility>

#include "actors/cluster/handshakes.h"
#include "actors/cluster/network.h"
#include "actors/failing.h"

namespace tessera {
namespace {

constexpr std::chrono::milliseconds pause{500};  // before an address is tried again
constexpr int attempts_max = 6;                  // to reach a node that others reach
constexpr unsigned ticks_a_lease = 5;

}  // namespace

Member::Member(caf::actor_config& config, MemberOptions options) : SteadyActor(config), options_(std::move(options)) {}

void Member::on_exit() {
  registry_ = nullptr;
  doors_.clear();
  options_.registry = options_.node = nullptr;
}

void Member::failed(const std::exception_ptr& exception) noexcept {
  options_.cluster.expelled(
      failure_of(exception, [] { return std::string("the membership of this node in the cluster"); }).text, true);
}

Member::behavior_type Member::make_behavior() {
  set_error_handler([](caf::scheduled_actor*, caf::error&) {});  // actors that matter are monitored
  set_down_handler([this](caf::scheduled_actor*, caf::down_msg& down) { gone(down); });
  send(this, caf::connect_atom::value);
  send(this, caf::tick_atom::value);
  return {
      [this](const WhoIs& who) {
        // Not the handle: messages to a handle that was learnt from a process pass through that process.
        CoordinatorIs answer;
        if (registry_) answer.address = coordinator_address_;
        send(caf::actor_cast<MemberHandle>(who.asks), std::move(answer));
      },
      [this](const CoordinatorIs& is) {
        heard(current_sender());
        if (state_ != State::seeking) return;
        if (is.registry) return greet(is.registry);
        if (const auto address = parse_host_port(is.address)) ask(address.value());
      },
      [this](const Welcome& message) { welcome(message); },
      [this](const Refused& refused) {
        tell_trouble("refused by the cluster's coordinator: " + refused.why);
        lost_registry();
      },
      [this](const Renewed&) {
        answered_ = Clock::now();
        answered_since_ = true;
      },
      [this](const Expelled& expelled) { expel(expelled); },
      [this](const AskToLeave&) { leave(); },
      [this](const Leave&) { quit(); },
      [this](const AskStatus&) { return membership_status(); },
      [this](caf::tick_atom) { renew(); },
      [this](caf::connect_atom) { seek(); },
  };
}

void Member::seek_later() {
  if (!std::exchange(will_seek_, true)) delayed_send(this, pause, caf::connect_atom::value);
}

void Member::seek() {
  will_seek_ = false;
  if (state_ != State::seeking || expelled_) return;
  if (options_.registry) return greet(options_.registry);
  const auto& join = options_.cluster.join;
  if (join.empty()) return;
  if (to_ask_.empty()) {
    auto addresses = addresses_of(join[next_name_++ % join.size()]);
    if (!addresses) {
      tell_trouble("no node of the cluster can be reached yet: " + addresses.error().where);
      return seek_later();
    }
    to_ask_.assign(addresses.value().begin(), addresses.value().end());
  }
  const HostPort next = to_ask_.front();
  to_ask_.pop_front();
  ask(next);
}

// Logs a trouble once, as long as it stays the same.
void Member::tell_trouble(const std::string& trouble) {
  if (last_trouble_ != trouble) options_.cluster.log(trouble);
  last_trouble_ = trouble;
}

void Member::ask(const HostPort& address) {
  reach(
      this, address,
      [this, address](const caf::actor& door) {
        if (state_ != State::seeking) return;
        // A process that has died and come back does not know the number by which the old handle asks it.
        send(caf::actor_cast<RegistryHandle>(door), WhoIs{caf::actor_cast<caf::actor>(this)});
        seek_later();  // for the case that no answer comes
      },
      [this, address](const std::string& reason) {
        tell_trouble("no node of the cluster can be reached at " + to_string(address) + " yet: " + reason +
                     own_certificate());
        seek_later();
      });
}

// The other side may have closed the connection before it said why, so an expired certificate is named here.
std::string Member::own_certificate() const {
  const auto end = std::chrono::system_clock::time_point(std::chrono::seconds(options_.info.certificate_end_s));
  if (options_.info.certificate_end_s == 0 || std::chrono::system_clock::now() < end) return {};
  return "; the certificate of this node has expired: " + options_.cluster.certificate.string();
}

void Member::greet(const caf::actor& registry) {
  state_ = State::greeting;
  registry_ = caf::actor_cast<RegistryHandle>(registry);
  monitor(registry_);
  answered_ = Clock::now();
  Hello hello;
  hello.cluster = options_.cluster.name;
  hello.shared = options_.cluster.shared;
  hello.info = options_.info;
  hello.use = options_.use();
  hello.last_words = options_.last_words;
  hello.member = caf::actor_cast<caf::actor>(this);
  hello.node = options_.node;
  send(registry_, std::move(hello));
}

void Member::welcome(const Welcome& message) {
  if (state_ != State::greeting || message.uuids.size() != message.addresses.size()) return;
  state_ = State::member;
  last_trouble_.clear();
  answered_ = Clock::now();
  coordinator_address_ = message.coordinator;
  options_.cluster.log("member of the cluster " + options_.cluster.name);
  if (leaves_) leave();  // before this node is free for work
  for (std::size_t i = 0; i < message.uuids.size(); ++i) {
    // A coordinator before this one may have been told, or not.
    if (gone_.contains(message.uuids[i])) send(registry_, Unreachable{options_.info.uuid, message.uuids[i]});
    if (gone_.contains(message.uuids[i]) || doors_.contains(message.uuids[i])) continue;  // known from before
    const auto address = parse_host_port(message.addresses[i]);
    if (address) {
      doors_[message.uuids[i]].address = message.addresses[i];
      reach_node(message.uuids[i], address.value(), attempts_max);
    }
  }
  reached({}, nullptr);
}

void Member::reach_node(const NodeUuid& uuid, const HostPort& address, int attempts) {
  reach(
      this, address, [this, uuid](const caf::actor& door) { reached(uuid, door); },
      [this, uuid, address, attempts](const std::string& reason) {
        if (expelled_) return;
        if (attempts > 1) return reach_node(uuid, address, attempts - 1);
        options_.cluster.log("node at " + to_string(address) + " cannot be reached: " + reason);
        // One of the two nodes is lost now, or the other one was lost already. Perhaps all of the remaining nodes are
        // reached.
        do_without(uuid);
        reached({}, nullptr);
      });
}

void Member::reached(const NodeUuid& uuid, const caf::actor& door) {
  if (const auto found = doors_.find(uuid); found != doors_.end() && door) {
    found->second.handle = door;
    monitor(door);
  }
  const bool all = std::all_of(doors_.begin(), doors_.end(), [](const auto& entry) { return entry.second.handle; });
  if (all && state_ == State::member) send(registry_, ReachedAll{options_.info.uuid});
}

void Member::renew() {
  if (const auto closed = close_mute_connections(options_.cluster.lease); closed > 0)
    options_.cluster.log(std::to_string(closed) + " connections were closed because no message came over them");
  delayed_send(this, options_.cluster.lease / ticks_a_lease, caf::tick_atom::value);
  for (const std::string& trouble : take_handshake_troubles()) options_.cluster.log(trouble);
  if (leaves_) leave();
  if (state_ == State::seeking) return;
  if (Clock::now() - answered_ > options_.cluster.lease) {
    options_.cluster.log(
        "the cluster's coordinator has been silent for longer than the lease: this node goes on with its tiles "
        "meanwhile");
    return lost_registry();
  }
  if (state_ != State::member) return;
  send(registry_, Renew{options_.info.uuid, options_.use()});
  ask_others();
  // Said again, because the coordinator does not accept it while another node counts as a member and is unreachable.
  reached({}, nullptr);
}

// A connection lasts for the grace, so that a process that stands still keeps its connections and goes on with them. So
// a node from which nothing comes is found here, by the lease. No node is given up while the coordinator is not heard
// either: both may be one process, or this process may have stood still itself.
void Member::ask_others() {
  std::vector<NodeUuid> silent;
  for (auto& [uuid, door] : doors_) {
    if (!door.handle) continue;
    if (answered_since_ && ++door.asked > ticks_a_lease) silent.push_back(uuid);
    send(caf::actor_cast<RegistryHandle>(door.handle), WhoIs{caf::actor_cast<caf::actor>(this)});
  }
  answered_since_ = false;
  for (const NodeUuid& uuid : silent) {
    options_.cluster.log("node at " + doors_[uuid].address + " has been silent for longer than the lease");
    do_without(uuid);
  }
}

void Member::heard(const caf::strong_actor_ptr& door) {
  for (auto& [uuid, known] : doors_) {
    if (known.handle && known.handle.address() == door) known.asked = 0;
  }
}

void Member::gone(const caf::down_msg& down) {
  if (registry_ && down.source == registry_.address()) {
    options_.cluster.log("the cluster's coordinator does not answer any more");
    return lost_registry();
  }
  for (auto& [uuid, door] : doors_) {
    if (!door.handle || door.handle.address() != down.source) continue;
    return do_without(NodeUuid(uuid));
  }
}

// Messages that were on their way may be lost, so this node does not connect to the other one again.
void Member::do_without(const NodeUuid& uuid) {
  if (const auto found = doors_.find(uuid); found != doors_.end()) {
    if (found->second.handle) forget(home_system(), found->second.handle);
    doors_.erase(found);
  }
  gone_.insert(uuid);
  if (state_ == State::member) send(registry_, Unreachable{options_.info.uuid, uuid});
}

// Tiles go on meanwhile.
void Member::lost_registry() {
  if (state_ == State::seeking) return;
  state_ = State::seeking;
  if (registry_) {
    demonitor(registry_.address());
    if (!options_.registry) forget(home_system(), caf::actor_cast<caf::actor>(registry_));
  }
  registry_ = nullptr;
  leave_unheard();
  seek_later();
}

void Member::leave() {
  if (expelled_) return;
  if (!std::exchange(leaves_, true)) options_.cluster.log("this node leaves the cluster: its tiles go to other nodes");
  if (state_ == State::member) send(registry_, Leaving{options_.info.uuid, options_.jobs()});
  leave_unheard();
}

// The next coordinator would have nothing to take from this node.
void Member::leave_unheard() {
  if (leaves_ && state_ == State::seeking && options_.jobs() == 0)
    expel({"had no tiles that other nodes would continue", false});
}

MembershipStatus Member::membership_status() const {
  MembershipStatus status;
  status.member = state_ == State::member && !expelled_;
  status.leaves = leaves_;
  status.others = static_cast<std::uint64_t>(
      std::count_if(doors_.begin(), doors_.end(), [](const auto& entry) { return entry.second.handle != nullptr; }));
  status.silent_ms = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - answered_).count());
  if (expelled_) {
    status.trouble = "no member of the cluster any more";
  } else if (leaves_) {
    status.trouble = "leaves the cluster";
  } else if (state_ == State::greeting) {
    status.trouble = "the cluster's coordinator has not answered yet";
  } else if (state_ == State::seeking) {
    status.trouble = "looks for the cluster's coordinator" + (last_trouble_.empty() ? "" : ": " + last_trouble_);
  }
  return status;
}

void Member::expel(const Expelled& expelled) {
  if (std::exchange(expelled_, true)) return;
  options_.cluster.expelled(expelled.why, expelled.again);
}

}  // namespace tessera

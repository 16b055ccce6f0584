// Keeps a node in its cluster: it finds the coordinator, connects to all other nodes, and renews the node's lease.
//
// state    | message             | effect                                                                  | next
// seeking  | connect             | ask the next address of --join                                          | seeking
// seeking  | CoordinatorIs       | send Hello there                                                        | greeting
// greeting | Welcome             | connect to every other node; then ReachedAll                            | member
// greeting, seeking | Refused    | tell why, and try again later                                           | seeking
// member   | tick                | Renew, and ReachedAll again; WhoIs to every other node, which answers   |
// member   | tick, without an answer for the lease | as when the coordinator is gone                       | seeking
// any      | coordinator is gone | go on with its tiles, and look for another coordinator                  | seeking
// any      | another node is gone, or cannot be reached | Unreachable to the coordinator; do without that node
// member   | another node has not answered for the lease, in which the coordinator has | the same
// any      | AskStatus           | answer with the node's state                                            |
// any      | AskToLeave          | Leaving to the coordinator, now and at every tick, and to those after it; without a
//          |                     | coordinator, and without anything that others could go on with, the process ends
// any      | Expelled            | the process must begin anew, or end                                     | ended
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "actors/cluster/messages.h"
#include "actors/steady_actor.h"
#include "src/cluster/cluster_options.h"

namespace tessera {

struct MemberOptions {
  ClusterOptions cluster;
  MemberInfo info;
  std::string last_words;  // how the process before this one ended; empty: in order
  caf::actor registry;     // of the same process; null: another process coordinates
  caf::actor node;
  std::function<NodeUse()> use;
  std::function<std::uint64_t()> jobs;  // number of jobs that it works for
};

class Member : public SteadyActor<MemberHandle, Pool::deciding> {
 public:
  Member(caf::actor_config& config, MemberOptions options);
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  enum class State : std::uint8_t { seeking, greeting, member };
  using Clock = std::chrono::steady_clock;

  void failed(const std::exception_ptr& exception) noexcept override;
  void seek();
  void tell_trouble(const std::string& trouble);
  void seek_later();
  std::string own_certificate() const;  // what is wrong with it
  void ask(const HostPort& address);
  void greet(const caf::actor& registry);
  void welcome(const Welcome& message);
  void reach_node(const NodeUuid& uuid, const HostPort& address, int attempts);
  void reached(const NodeUuid& uuid, const caf::actor& door);
  void renew();
  void gone(const caf::down_msg& down);
  void ask_others();
  void heard(const caf::strong_actor_ptr& door);
  void do_without(const NodeUuid& uuid);
  void lost_registry();
  void leave();
  void leave_unheard();
  void expel(const Expelled& expelled);
  MembershipStatus membership_status() const;

  MemberOptions options_;
  State state_ = State::seeking;
  std::size_t next_name_ = 0;
  std::deque<HostPort> to_ask_;  // addresses of the last name
  std::string last_trouble_;
  RegistryHandle registry_;
  std::string coordinator_address_;
  struct Door {
    std::string address;
    caf::actor handle;  // null: not reached yet
    // How often it was asked since it was last heard, counting only ticks at which the coordinator was heard.
    unsigned asked = 0;
  };
  std::map<NodeUuid, Door> doors_;  // of other nodes
  std::set<NodeUuid> gone_;         // nodes that could not be reached, or are not reachable any more
  Clock::time_point answered_ = Clock::now();
  bool answered_since_ = false;  // answered since the last tick
  bool will_seek_ = false, leaves_ = false, expelled_ = false;
};

}  // namespace tessera

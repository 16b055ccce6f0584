// A node's place in a cluster: it finds the coordinator, reaches all other nodes, and renews its lease.
//
// state    | message        | effect                                                                       | next
// seeking  | connect        | asks the next address of those it was given                                  | seeking
// seeking  | CoordinatorIs  | says Hello there                                                             | greeting
// greeting | Welcome        | reaches every other node; then ReachedAll                                    | member
// greeting, seeking | Refused | tells why, and tries again later                                          | seeking
// member   | tick           | Renew, and ReachedAll again; WhoIs to every other node, which answers        |
// member   | tick, not answered for the lease | as when the coordinator is gone                            | seeking
// any      | coordinator is gone | goes on with its tiles, and looks for another one                       | seeking
// any      | another node is gone, or cannot be reached | Unreachable; it is done without                  |
// member   | another node has not answered for the lease, in which the coordinator has | the same             |
// any      | AskPlace       | answers with its state                                                       |
// any      | AskToLeave     | it leaves: Leaving to the coordinator, now, at every tick, and to those after it;
//          |                | when there is none, and nothing that others would go on with, the process ends
// any      | Expelled       | the process must begin anew, or end                                          | ended
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
  caf::actor registry;     // of the same process; null: another one coordinates
  caf::actor node;
  std::function<NodeUse()> use;
  std::function<std::uint64_t()> jobs;  // that it is at work for
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
  NodePlace place() const;

  MemberOptions options_;
  State state_ = State::seeking;
  std::size_t next_name_ = 0;
  std::deque<HostPort> to_ask_;  // addresses of the last name
  std::string last_trouble_;
  RegistryHandle registry_;
  std::string coordinator_address_;
  struct Door {
    std::string address;
    caf::actor handle;   // null: not reached yet
    unsigned asked = 0;  // times since it was heard, in each of which the coordinator was
  };
  std::map<NodeUuid, Door> doors_;  // of other nodes
  std::set<NodeUuid> gone_;         // were reached, and are not any more, or could not be
  Clock::time_point answered_ = Clock::now();
  bool answered_since_ = false;  // the last tick
  bool will_seek_ = false, leaves_ = false, expelled_ = false;
};

}  // namespace tessera

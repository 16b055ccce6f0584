// The coordinator of a cluster: it knows which nodes are members, for how long, and which jobs must hear of them
// (src/cluster/members.h).
//
// message     | effect                                                           | answer
// WhoIs       | -                                                                | CoordinatorIs
// Hello       | a member, if version, cluster and data folder are the same       | Welcome, Refused; Expelled
// ReachedAll  | the node is free for work: NodeJoined to every job               | -
// Renew       | the node's lease begins anew                                     | Renewed
// Unreachable | one of the two nodes will be lost                                | -
// Follow      | this job hears of nodes from now on: NodeJoined for each         | -
// Drain       | NodeLeaves to every job; nothing when no other node is free      | whether there is such a node, and
//             |                                                                  | why it stays
// Leaving     | the same for its sender, though it is the only node; later ones  | -
//             | say whether it works for jobs that are still to come             |
// NodeLet     | when all jobs have sent it: AskToLeave, as the node may work for | -
//             | jobs that are still to come; Expelled for ever when it does not  |
// AskMembers  | -                                                                | MemberList
// a member is gone, tick | NodeLost to every job; Expelled to the node           | -
#pragma once

#include <chrono>
#include <map>
#include <set>
#include <string>

#include "actors/cluster/messages.h"
#include "actors/steady_actor.h"
#include "src/cluster/cluster_options.h"
#include "src/cluster/members.h"

namespace tessera {

class Registry : public SteadyActor<RegistryHandle, Pool::deciding> {
 public:
  Registry(caf::actor_config& config, ClusterOptions options);
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  struct Actors {
    MemberHandle member;
    caf::actor node;
    std::string last_words;
  };

  void failed(const std::exception_ptr& exception) noexcept override;
  void welcome(const Hello& hello);
  std::string refusal(const Hello& hello) const;
  void tell_refused(const std::string& line);
  // `again` says whether its process may come back, as another node.
  void lose(const Members::Loss& loss, bool again = true);
  void follow(const caf::actor& job);
  Drained drain(const std::string& node);
  void hear(const Leaving& leaving);
  void begin_leaving(const NodeUuid& uuid);
  void ask_to_let(const NodeUuid& uuid, const FollowerHandle& job);
  void let(const FollowerHandle& job, const NodeUuid& uuid);
  void let_if_over(const NodeUuid& uuid);
  void gone(const caf::down_msg& down);
  void tick();
  MemberList list() const;

  ClusterOptions options_;
  Members members_;
  std::map<NodeUuid, Actors> actors_;
  std::set<FollowerHandle> jobs_;
  struct Going {
    std::set<FollowerHandle> jobs;  // that still have something there
    bool at_work = true;            // as far as the node has said: for these jobs, or for jobs that are still to come
  };
  std::map<NodeUuid, Going> leaving_;
  std::uint64_t lost_ = 0;
  // Sentences, with the time at which they were last told.
  std::map<std::string, std::chrono::steady_clock::time_point> refused_;
};

}  // namespace tessera

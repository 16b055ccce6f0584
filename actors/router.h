// Hands the input splits of an input to nodes, one at a time to each node, until all are routed.
//
// message                | effect
// SplitRouted            | progress; or the node gets the next split. When the node could not route the split, the
//                        | split goes to the owner, who can read everything. The node gets no more splits, because it
//                        | may not see the files
// NodeJoined             | a split for the node
// NodeLost, NodeLeaves   | the node's split goes to another node
// a node's actor is gone | as for NodeLost
// Cancel                 | the end
//
// While there is no node, the owner gets the splits, one at a time.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "actors/protocol.h"
#include "actors/steady_actor.h"

namespace tessera {

// The code that has an input routed. Called from the router's thread.
class RoutingOwner {
 public:
  virtual ~RoutingOwner() = default;
  virtual void progressed(std::uint64_t so_far) = 0;  // how much of all splits is routed
  // Asks the owner to route the split itself, and to send SplitRouted. `why` is the failure of a node that could not
  // route it. `why` is empty when there is no node, or when only this process can read the split.
  virtual void route_here(std::uint32_t split, std::uint32_t attempt, std::string why) = 0;
  // Called exactly once, at the end. `attempts` has, by split, the attempt that counts; `failure` says why there is
  // none. The router does not use its owner after that.
  virtual void ended(std::vector<std::uint32_t> attempts, Failure failure) noexcept = 0;
};

struct RouterOptions {
  std::string run_folder;
  std::uint32_t shares = 1;
  std::vector<bool> here;  // by split: only the owner can read it
};

class Router : public SteadyActor<RouterHandle, Pool::deciding> {
 public:
  Router(caf::actor_config& config, RouterOptions options, RoutingOwner& owner, const std::vector<NodeHandle>& nodes);
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  struct Attempt {
    std::uint32_t split = 0;
    NodeHandle node;  // null: the owner
    std::uint64_t routed = 0;
  };

  void failed(const std::exception_ptr& exception) noexcept override;
  void join(const NodeHandle& node);
  void lose(const caf::actor_addr& node);
  void take(SplitRouted& routed);
  void hand_out();
  std::uint32_t begin(std::uint32_t split, NodeHandle node);
  void end(Failure failure) noexcept;

  RouterOptions options_;
  RoutingOwner* owner_;  // null: it was told the end
  std::deque<std::uint32_t> waiting_;
  std::deque<std::uint32_t> for_owner_;
  std::vector<NodeHandle> nodes_;             // that route
  std::map<std::uint32_t, Attempt> at_work_;  // by number of the attempt
  std::vector<std::uint32_t> routed_;         // by split: the attempt that counts, or 0
  std::size_t left_;
  std::uint64_t routed_so_far_ = 0;  // of the splits that are done
  std::uint32_t attempts_ = 0;
  std::string why_here_;
};

}  // namespace tessera

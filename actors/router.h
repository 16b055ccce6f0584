// Hands the stretches of an input to nodes, each one at a time, until all are routed.
//
// message       | effect
// SplitRouted | progress; or the node's next stretch; or, when it could not, the stretch goes to the owner, who can
// read
//               | everything, and the node gets no more: it may not see the files
// NodeJoined    | a stretch for it
// NodeLost, NodeLeaves | its stretch is another's
// a node is gone without a word | as NodeLost
// Cancel        | the end
//
// While there is no node the owner gets the stretches, one at a time.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "actors/protocol.h"
#include "actors/steady_actor.h"

namespace tessera {

// Whoever has stretches routed. Called from the router's thread.
class RoutingOwner {
 public:
  virtual ~RoutingOwner() = default;
  virtual void progressed(std::uint64_t so_far) = 0;  // of what all stretches have
  // Route it yourself, and say SplitRouted. `why`: of a node that could not; empty: there is none, or none but this
  // process can.
  virtual void route_here(std::uint32_t split, std::uint32_t attempt, std::string why) = 0;
  // Always called in the end, once: by stretch, the attempt that counts; or why there is none. The router does not know
  // its owner any more then.
  virtual void ended(std::vector<std::uint32_t> attempts, Failure failure) noexcept = 0;
};

struct RouterOptions {
  std::string run_folder;
  std::uint32_t shares = 1;
  std::vector<bool> here;  // by stretch: only the owner can read it
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
  RoutingOwner* owner_;  // null: it has been told the end
  std::deque<std::uint32_t> waiting_;
  std::deque<std::uint32_t> for_owner_;
  std::vector<NodeHandle> nodes_;             // that route
  std::map<std::uint32_t, Attempt> at_work_;  // by number
  std::vector<std::uint32_t> routed_;         // by stretch: the attempt that counts, or 0
  std::size_t left_;
  std::uint64_t routed_so_far_ = 0;  // of stretches that are routed
  std::uint32_t attempts_ = 0;
  std::string why_here_;
};

}  // namespace tessera

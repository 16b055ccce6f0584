// The faults of nodes in a run. They are drawn in advance, each with the step at which it happens. Nodes are killed;
// stop for a while and go on; are given up while they work; join; leave in order; or all of them are lost, and others
// come. The coordinator stops, another one takes over, and the first one may go on after that.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "actors/harness/harness.h"
#include "src/base/ids.h"

namespace tessera {

// Receives the faults. Nodes are numbered in the order in which they come.
class Misfortune {
 public:
  virtual ~Misfortune() = default;
  virtual void stop(NodeId node) = 0;
  virtual void go_on(NodeId node) = 0;
  virtual void give_up(NodeId node) = 0;
  virtual void join(NodeId node) = 0;
  virtual void leave(NodeId node) = 0;
  virtual void join_in_vain(NodeId node) = 0;  // the node cannot open its share
  virtual void lose(NodeId node) = 0;          // and the coordinator, which would notice it, too
  virtual void stop_coordinator() = 0;
  virtual void take_over() = 0;
  virtual void coordinators_go_on() = 0;  // those that were stopped
};

class Losses {
 public:
  // Draws the faults. At least one usable node is there in the end.
  Losses(const HarnessFaults& faults, std::uint32_t nodes, std::mt19937_64& rng);

  // Makes happen what is due by this step.
  void befall(std::uint64_t step, Misfortune& whom);
  // Returns the step of the next event, for when nothing else can happen. Empty: there are no more events.
  std::optional<std::uint64_t> next_step() const;
  // Returns whether there was, or will be, any event.
  bool any() const { return any_; }

 private:
  enum class What : std::uint8_t {
    stop,
    go_on,
    give_up,
    join,
    leave,
    join_in_vain,
    lose,
    stop_coordinator,
    take_over,
    coordinators_go_on
  };
  struct Event {
    std::uint64_t step;
    What what;
    NodeId node;
  };
  void add(Event event);
  void lose_one(std::uint64_t step, bool stops, bool goes_on);
  void lose_last(std::uint64_t step);
  void leave_one(std::uint64_t step);
  void lose_all(std::uint64_t step, bool coordinator);
  void replace_coordinator(std::uint64_t step);
  std::uint64_t draw(std::uint64_t below) { return rng_() % below; }
  void come(std::uint64_t step);

  std::mt19937_64& rng_;
  struct There {
    NodeId node;
    std::uint64_t since = 0;  // the step since which it is there
  };
  There take_any();
  std::vector<There> there_;
  std::uint32_t numbered_;      // number of nodes so far
  std::uint64_t replaced_ = 0;  // the step at which the last coordinator takes over
  std::vector<Event> events_;   // sorted by step
  bool any_ = false;
};

}  // namespace tessera

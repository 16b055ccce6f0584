// What befalls the nodes of a run, drawn in advance, by the step at which it happens: some are killed, some stop for a
// while and go on after they have been given up, some are given up while they work, others join, or leave in order; all
// are lost, and others come; the coordinator stops, another one takes over, and the first goes on after that.
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "actors/harness/harness.h"
#include "src/base/ids.h"

namespace tessera {

// Whom it befalls. Nodes are numbered in the order in which they come.
class Misfortune {
 public:
  virtual ~Misfortune() = default;
  virtual void stop(NodeId node) = 0;
  virtual void go_on(NodeId node) = 0;
  virtual void give_up(NodeId node) = 0;
  virtual void join(NodeId node) = 0;
  virtual void leave(NodeId node) = 0;
  virtual void join_in_vain(NodeId node) = 0;  // it cannot open its part
  virtual void lose(NodeId node) = 0;          // with whoever would notice
  virtual void stop_coordinator() = 0;
  virtual void take_over() = 0;
  virtual void coordinators_go_on() = 0;  // those that were stopped
};

class Losses {
 public:
  // At least one node is there in the end.
  Losses(const HarnessFaults& faults, std::uint32_t nodes, std::mt19937_64& rng);

  // What is due at this step.
  void befall(std::uint64_t step, Misfortune& whom);
  // When nothing else can happen: the step of what comes next. None: all is over.
  std::optional<std::uint64_t> next_step() const;
  // Whether there was, or will be, anything.
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
    std::uint64_t since = 0;  // step
  };
  There take_any();
  std::vector<There> there_;
  std::uint32_t numbered_;      // nodes so far
  std::uint64_t replaced_ = 0;  // when the last coordinator is
  std::vector<Event> events_;   // by step
  bool any_ = false;
};

}  // namespace tessera

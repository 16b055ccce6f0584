// Decides when no tile is working and no update is under way, by Mattern's four-counter method over nodes.
// A wave asks every node for its totals. One wave alone may be wrong: a node that was asked early may have been woken
// by an update from a node that was asked late. Two successive waves in which every node is idle and all four sums are
// equal cannot be wrong: between the end of the first wave and the beginning of the second one nothing was sent or
// processed, and nothing was under way. Source: Mattern, Algorithms for distributed termination detection, Distributed
// Computing 2, 1987.
//
// The times at which waves begin change only the number of waves, not the decision. A wave begins when every node has
// said that it is idle, no node has answered since that it is busy, and at least one node has said that it is idle
// since the last wave began. Such a wave always comes: a node that has answered that it is busy says later that it is
// idle. When all nodes were idle and the sums differed, an update was under way to a node that had answered, or came
// from one. So that node is busy after its answer, and says later that it is idle.
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "src/exchange/counters.h"

namespace tessera {

class QuiescenceDetector {
 public:
  enum class Verdict : std::uint8_t {
    wait,   // answers of this wave are missing, or it failed and nothing has changed since
    probe,  // start a wave: ask every node, with wave() as its number
    quiet,  // proven: all is quiet
  };

  explicit QuiescenceDetector(std::set<NodeId> nodes) : nodes_(std::move(nodes)) {}

  // Asks `nodes` from now on, and forgets all earlier answers. The numbers of waves go on. A node that has said that it
  // is idle need not say so again.
  void restart(std::set<NodeId> nodes);
  // Does the same, and takes all nodes for busy until they say that they are idle.
  void restart_busy(std::set<NodeId> nodes);

  // A node says that it has become idle. It says so at least once after each of its answers and after restart_busy().
  // REQUIRES: notices and answers of one node come in the order in which the node sent them.
  Verdict notice(NodeId node);
  // After restart(): returns whether a wave is to begin.
  Verdict look();
  // A node's answer to a probe. `idle` means that no tile is working, no mail waits, and no tile is still to begin.
  // Answers to an older wave, and second answers, are ignored.
  Verdict answer(Wave wave, NodeId node, bool idle, Totals totals);

  Wave wave() const { return wave_; }

 private:
  Verdict begin();
  Verdict judge();
  Verdict begin_if_worth();

  std::set<NodeId> nodes_;
  std::set<NodeId> idle_;  // those of nodes_ that are idle, as far as is known
  Wave wave_;
  bool in_wave_ = false;
  bool noticed_ = false;  // some node has said that it is idle since the last wave began
  bool all_idle_ = true;
  Totals sum_;
  std::set<NodeId> answered_;
  std::optional<Totals> previous_;  // sums of the last wave, if it could have been quiet
};

}  // namespace tessera

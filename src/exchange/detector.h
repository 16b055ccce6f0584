// Decides when nothing is left to say: Mattern's four-counter method over nodes.
// A wave asks every node for its totals. One wave may lie: a node asked early may have been woken by a message sent by
// a node asked late. Two successive waves in which every node is idle and all four sums agree cannot: between the end
// of the first and the beginning of the second nothing was sent or processed, and nothing was on its way. Source:
// Mattern, Algorithms for distributed termination detection, Distributed Computing 2, 1987.
//
// When waves begin decides only how many there are. One is worth its messages when every node has said that it is idle,
// none has answered since that it is not, and at least one has said so since the last wave began. It begins at last: a
// node that has answered that it is busy will say that it is idle; where all were idle and the sums differ, a message
// was on its way to a node that had answered, or came from one, and that node is busy after its answer, and then idle.
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
    probe,  // start a wave: ask every node with wave()
    quiet,  // proven
  };

  explicit QuiescenceDetector(std::set<NodeId> nodes) : nodes_(std::move(nodes)) {}

  // From now on these are asked; what was answered before tells nothing. Waves are counted on. Who has said that it is
  // idle need not say so again.
  void restart(std::set<NodeId> nodes);
  // The same, and all of them have something to do now.
  void restart_busy(std::set<NodeId> nodes);

  // A node reports that it has become idle, at least once after each of its answers and after restart_busy(). What it
  // says comes in the order in which it says it, answers included.
  Verdict notice(NodeId node);
  // Whether there is a reason for a wave, after restart().
  Verdict look();
  // A node's answer to a probe. `idle`: no tile working, no mail waiting, none still to begin. Answers to an
  // older wave, and second answers, are ignored.
  Verdict answer(Wave wave, NodeId node, bool idle, Totals totals);

  Wave wave() const { return wave_; }

 private:
  Verdict begin();
  Verdict judge();
  Verdict begin_if_worth();

  std::set<NodeId> nodes_;
  std::set<NodeId> idle_;  // of them, as far as is known
  Wave wave_;
  bool in_wave_ = false;
  bool noticed_ = false;  // a notice has come since the last wave began
  bool all_idle_ = true;
  Totals sum_;
  std::set<NodeId> answered_;
  std::optional<Totals> previous_;  // sums of the last wave, if it could have been quiet
};

}  // namespace tessera

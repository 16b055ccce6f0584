// Decides when nothing is left to say: Mattern's four-counter method over nodes.
// A wave asks every node for its totals. One wave may lie: a node asked early may have been woken by a message sent by
// a node asked late. Two successive waves in which every node is idle and all four sums agree cannot: between the end
// of the first and the beginning of the second nothing was sent or processed, and nothing was on its way. Source:
// Mattern, Algorithms for distributed termination detection, Distributed Computing 2, 1987.
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "src/quiescence/counters.h"

namespace tessera {

class QuiescenceDetector {
 public:
  enum class Verdict : std::uint8_t {
    wait,   // answers of this wave are missing, or it failed and nothing has changed since
    probe,  // start a wave: ask every node with wave()
    quiet,  // proven
  };

  explicit QuiescenceDetector(std::set<NodeId> nodes) : nodes_(std::move(nodes)) {}

  // From now on these are asked; what was answered before tells nothing. Waves are counted on.
  void restart(std::set<NodeId> nodes);

  // A node reports that it has become idle: a reason to look.
  Verdict notice();
  // A node's answer to a probe. `idle`: no tile working, no mail waiting, none still to be triangulated. Answers to an
  // older wave, and second answers, are ignored.
  Verdict answer(std::uint64_t wave, NodeId node, bool idle, Totals totals);

  std::uint64_t wave() const { return wave_; }

 private:
  Verdict begin();
  Verdict judge();

  std::set<NodeId> nodes_;
  std::uint64_t wave_ = 0;
  bool in_wave_ = false;
  bool noticed_ = false;  // a notice came during a wave
  bool all_idle_ = true;
  Totals sum_;
  std::set<NodeId> answered_;
  std::optional<Totals> previous_;  // sums of the last wave, if it could have been quiet
};

}  // namespace tessera

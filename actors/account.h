// What a job has done so far, as its parts tell it: its progress while it runs, sums and durations at its end. Pure: it
// is told the time.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "actors/run_owner.h"

namespace tessera {

class Account {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit Account(Time now) : started_(now) { before_.reserve(1); }

  // The first stage begins; settled: nothing is left of it but its end. Then the next one.
  void start(Time now, bool settled);
  void begin_stage(Time now);
  // The steps of a stage, each as it begins. A step that begins again counts from its first beginning, but for the
  // last.
  void all_have_begun(Time now) {
    if (!begun_) begun_ = now;
  }
  void is_quiet(Time now) { quiet_ = now; }
  void is_not_quiet() { quiet_.reset(); }  // after all
  RunStep step() const;

  void node_came() { ++nodes_; }
  void node_lost() { ++nodes_lost_; }
  void tiles_begin_again(std::uint64_t tiles) { tiles_again_ += tiles; }

  // What one of `nodes` nodes says. True when the owner is to hear of it: of many nodes an eighth speak before all are
  // added up, or their words would cost the square of their number.
  bool heard(NodeId node, ShareProgress said, std::size_t nodes);
  bool has_untold() const { return spoken_ > 0; }
  struct Node {
    std::string name;  // none: it is not told of by itself
    std::uint32_t tiles = 0;
    bool lost = false, left = false;  // left: in order
  };
  // For the owner. Spans and mail are told once. `nodes`: by number.
  RunProgress progress(const std::vector<Node>& nodes);

  void ended(const ShareEnded& part);
  // Without failure and memory. Once; takes no memory, of which there may be none.
  RunEnded end(Time now, std::uint64_t waves);

 private:
  std::vector<ShareProgress> said_;  // by node: the last, without spans and mail
  std::vector<WorkSpan> untold_;
  std::vector<MailArc> untold_mail_;
  std::size_t spoken_ = 0;  // times that a part has spoken since the owner was told
  std::uint32_t nodes_ = 0, nodes_lost_ = 0;
  std::uint64_t tiles_again_ = 0;
  ShareEnded sum_;
  Time started_;
  std::optional<Time> begun_, quiet_;
  StageTimes times(Time now) const;
  std::vector<StageTimes> before_;  // of the stages that have ended, with room for one more
};

}  // namespace tessera

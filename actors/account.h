// What a job has done so far, as its shares tell it: its progress while it runs, sums and durations at its end. A plain
// object without actors and clock: it is told the time. Not thread-safe.
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

  // start(): the first stage begins; with `settled` only its end is left. begin_stage(): the next stage begins.
  void start(Time now, bool settled);
  void begin_stage(Time now);
  // The steps of a stage, each told when it begins. When tiles begin again, the time of all_have_begun() stays the
  // first one, and that of is_quiet() becomes the last one.
  void all_have_begun(Time now) {
    if (!begun_) begun_ = now;
  }
  void is_quiet(Time now) { quiet_ = now; }
  void is_not_quiet() { quiet_.reset(); }  // the job is disturbed after all was believed quiet
  RunStep step() const;

  void node_came() { ++nodes_; }
  void node_lost() { ++nodes_lost_; }
  void tiles_begin_again(std::uint64_t tiles) { tiles_again_ += tiles; }

  // Takes what one of `nodes` nodes says. Returns true when the owner of the run is to be told. With many nodes an
  // eighth of them speak before all are added up, because adding up after each message costs the square of their
  // number.
  bool heard(NodeId node, ShareProgress said, std::size_t nodes);
  bool has_untold() const { return spoken_ > 0; }
  struct Node {
    std::string name;  // empty: the node is not listed by itself
    std::uint32_t tiles = 0;
    bool lost = false, left = false;  // left: in order
  };
  // Returns the progress for the owner, with each work span and mail count once. `nodes` is by number.
  RunProgress progress(const std::vector<Node>& nodes);

  // Adds what a share says at its end.
  void ended(const ShareEnded& share);
  // Returns the sums, without `failure` and `memory_bytes`. Called once. Allocates nothing, because memory may be
  // short.
  RunEnded end(Time now, std::uint64_t waves);

 private:
  std::vector<ShareProgress> said_;  // by node: the last message, without spans and mail
  std::vector<WorkSpan> untold_;
  std::vector<MailArc> untold_mail_;
  std::size_t spoken_ = 0;  // number of messages of shares since the owner was told
  std::uint32_t nodes_ = 0, nodes_lost_ = 0;
  std::uint64_t tiles_again_ = 0;
  ShareEnded sum_;
  Time started_;
  std::optional<Time> begun_, quiet_;
  StageTimes times(Time now) const;
  std::vector<StageTimes> before_;  // of the stages that have ended, with room for one more
};

}  // namespace tessera

// The coordinator: knows when all is quiet (two successive equal waves, src/quiescence/detector.h) and ends the job.
//
// state      | message      | effect                                              | next
// exchanging | IdleNotice   | begin a wave: Probe to every node                    | exchanging
// exchanging | NodeTally    | when two waves agree: RunQuiet to the owner, CollectAll to nodes | collecting
// collecting | NodeFinished | when all have: RunEnded to the owner                 | ended
// any        | NodeFailed   | RunEnded with the error to the owner                 | ended
#pragma once

#include <caf/all.hpp>
#include <functional>
#include <set>
#include <vector>

#include "actors/protocol.h"
#include "src/quiescence/detector.h"

namespace tessera {

// Whom the coordinator serves: nodes are given later by a vector<actor> message, since they need its handle.
class Coordinator : public caf::event_based_actor {
 public:
  // `on_quiet`, when set, is called at the moment quiescence is believed: the harness checks there that it is true.
  Coordinator(caf::actor_config& config, caf::actor owner, std::uint32_t nodes, std::function<void()> on_quiet = {});
  caf::behavior make_behavior() override;
  void on_exit() override;

 private:
  void act(QuiescenceDetector::Verdict verdict);

  caf::actor owner_;
  std::function<void()> on_quiet_;
  std::vector<caf::actor> nodes_;
  QuiescenceDetector detector_;
  std::uint32_t expected_;
  std::set<std::uint32_t> finished_;
  bool collecting_ = false, ended_ = false;
};

}  // namespace tessera

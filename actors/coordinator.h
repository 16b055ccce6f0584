// The coordinator of one job: opens a part on every node, knows when all is quiet (two successive equal waves,
// src/quiescence/detector.h), and ends the job.
//
// state      | message          | effect                                                      | next
// opening    | PartOpened       | when all have: BeginPart to all                             | exchanging;
//            |                  |                                                             | collecting if settled
// exchanging | PartIdle         | begin a wave: Probe to every part                           | exchanging
// exchanging | PartTally        | when two waves agree: Settle to all                         | settling
// settling   | PartSettled      | when all have: mark the run settled, Collect to all         | collecting
// collecting | TileDone         | pass it on to the owner                                     | collecting
// any        | PartProgress     | progress to the owner                                       |
// any        | Cancel           | Suspend to all parts                                        | ending
// any        | PartEnded        | with a failure: Abort to the others; when all: the run has  | ending, ended
//            |                  | ended                                                       |
// collecting | PartEnded        | with damage: the run is not settled any more, too           | ending
// any        | a part or a node is gone | as PartEnded with a failure                         | ending, ended
// any        | an exception     | Abort to all parts                                          | ending
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "actors/prepared.h"
#include "actors/protocol.h"
#include "actors/run_owner.h"
#include "actors/steady_actor.h"
#include "src/quiescence/detector.h"
#include "src/run/part.h"

namespace tessera {

struct CoordinatorOptions {
  JobId job;
  PartSpec spec;
  // Writes down that the run is settled, or that it is not any more.
  std::function<Status(bool)> mark_settled;
  // When set, called at the moment quiescence is believed: the harness checks there that it is true.
  std::function<void()> on_quiet;
};

class Coordinator : public SteadyActor<CoordinatorHandle, Pool::deciding> {
 public:
  // `owner` outlives the run.
  Coordinator(caf::actor_config& config, CoordinatorOptions options, RunOwner& owner, std::vector<NodeHandle> nodes);
  void initialize() override;
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  enum class State : std::uint8_t { opening, exchanging, settling, collecting, ending };
  struct PartOf {
    NodeHandle node;
    PartHandle part;  // null before it is opened, and when it has ended
    bool opened = false, settled = false, begun = false, ended = false;
    PartProgress progress;
    Prepared<OpenPart> open;
    Prepared<Abort> abort;
  };

  void failed(const std::exception_ptr& exception) noexcept override;
  // Whatever goes wrong in a step ends the job and not the coordinator, which waits for all parts.
  template <class Step>
  void attempt(Step step) noexcept;
  void opened(const PartOpened& message);
  void begin();
  void act(QuiescenceDetector::Verdict verdict);
  void collect();
  void show_progress(PartProgress& message);
  void ended(PartEnded& message);
  void fail(Failure failure);
  void give_up(Failure failure) noexcept;
  void abort_parts() noexcept;
  void lost_actor(const caf::down_msg& down);
  void finish_if_over() noexcept;
  template <class Message>
  void tell_parts(const Message& message);
  template <class Done>
  bool all(Done done) const;

  CoordinatorOptions options_;
  RunOwner& owner_;
  std::vector<PartOf> parts_;  // by node
  QuiescenceDetector detector_;
  State state_ = State::opening;
  std::set<NodeId> settled_;
  std::optional<Failure> failure_;
  PartEnded sum_;
  std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  std::optional<std::chrono::steady_clock::time_point> begun_, quiet_;
  bool told_ = false, again_ = false;
};

}  // namespace tessera

// The coordinator of one job: opens a part on every node, knows when all is quiet (two successive equal waves,
// src/exchange/detector.h), places the tiles of lost nodes anew, and ends the job.
//
// state      | message          | effect                                                      | next
// finding    | ShareFound        | when all nodes have answered: a new table                   | where the parts are
// opening    | ShareOpened       | when all have: BeginShare to all                             | exchanging;
//            |                  |                                                             | collecting if settled
// exchanging | ShareIdle         | begin a wave: Probe to every part                           | exchanging
// exchanging | ShareTally        | when two waves agree: Settle to all                         | settling
// settling   | ShareSettled      | when all have: mark the run settled, Collect to all         | collecting
// collecting | TileDone         | pass it on to the owner                                     | collecting
// collecting | ShareCollected    | when all have: the next stage begins, by a new table       | exchanging;
//            |                  | after the last one Finish to all                            | finishing
// any        | NodeJoined       | open a part there; when it is open, Release to all others   |
// any        | NodeLeaves       | NodeLet, once nothing is to be done there (coordinator_leaving.cc)
// any        | ShareReleased     | a new epoch: what is released begins where work is wanted   |
// exchanging, settling | NodeLost | a new epoch: its tiles begin again on the others          | exchanging
// collecting | NodeLost         | a new epoch: what is not stored of its tiles is the others' | collecting
// any        | NodeLost, the last one | waits for another; fails when none has come for the grace    | ending
// finding, exchanging, collecting | a tile for which no node has the memory: the same (coordinator_room.cc)  |
// any        | a part is gone without a word | as NodeLost                                    |
// any        | ShareProgress     | progress to the owner                                       |
// any        | Cancel           | Suspend to all parts                                        | ending
// any        | ShareEnded        | with a failure of its node's scratch, and there are others: as NodeLost        |
// exchanging | ShareEnded        | without one, of a node that leaves: a new epoch, its tiles go on elsewhere
// any        | ShareEnded        | with a failure: Abort to the others; when all: the run has  | ending, ended
//            |                  | ended                                                       |
// collecting | ShareEnded        | with damage: the run is not settled any more, too           | ending
// any        | an exception     | Abort to all parts                                          | ending
#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "actors/account.h"
#include "actors/prepared.h"
#include "actors/protocol.h"
#include "actors/run_owner.h"
#include "actors/steady_actor.h"
#include "src/exchange/course.h"
#include "src/exchange/detector.h"
#include "src/exchange/placements.h"
#include "src/exchange/roster.h"
#include "src/exchange/share.h"

namespace tessera {

struct CoordinatorOptions {
  JobId job;
  ShareSpec spec;
  std::vector<std::uint64_t> weights;  // by tile: how much work it is, in a unit of the job's own; 0: there is none
  std::vector<TileId> order;           // of the tiles that there are: neighbours near each other
  // Claimed: of all coordinators of a job the one with the highest is obeyed. Takes over what an earlier one has begun.
  Term term;
  bool take_over = false;
  std::uint32_t stages = 1;  // that the job has
  // Writes down that a stage is settled, or that it is not any more.
  std::function<Status(std::uint32_t stage, bool)> mark_settled;
  // Whether another one has claimed a higher term: then this one has nothing to say any more, also if it fails.
  std::function<bool()> replaced;
  // Whether it is written down, and what is kept of the tiles that have come to its end: asked by one that takes over.
  std::function<Result<bool>(std::uint32_t stage)> is_settled;
  std::function<Result<std::vector<TileReceipt>>(std::uint32_t stage)> stored;
  // In which one the job begins when no node has a part of it: the last one that is settled.
  std::function<Result<std::uint32_t>()> first_stage;
  // How heavy a tile may be where so many threads and so much memory are; none: as heavy as it is.
  std::function<std::uint64_t(std::uint32_t threads, std::uint64_t memory_bytes)> weight_max;
  // What a tile of this weight is, and needs, for people: "a tile of size 5, which needs about 3 MiB".
  std::function<std::string(std::uint64_t weight)> tile_in_words;
  // When set, called at the moment quiescence is believed: the harness checks there that it is true.
  std::function<void(const RoutingTable&)> on_quiet;
  std::optional<NodeId> home;  // see Hooks
};

class Coordinator : public SteadyActor<CoordinatorHandle, Pool::deciding> {
 public:
  // `owner` outlives the run.
  Coordinator(caf::actor_config& config, CoordinatorOptions options, RunOwner& owner, std::vector<NodeHandle> nodes);
  void initialize() override;
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  using At = Course::At;
  using Standing = Roster::Standing;
  using Reached = Roster::Reached;
  // How a node and its part are reached; how they stand, the roster says.
  struct Participant {
    NodeHandle node;
    ShareHandle part;  // null before it is opened, and when it has ended
    Prepared<OpenShare> open;
    Prepared<Abort> abort;
  };

  void failed(const std::exception_ptr& exception) noexcept override;
  // Whatever goes wrong in a step ends the job and not the coordinator, which waits for all parts.
  template <class Step>
  void attempt(Step step) noexcept;
  void opened(const ShareOpened& message);
  void not_opened(const ShareOpened& message);
  void begin();
  void begin_if_opened();
  void find(const NodeHandle& node);
  void found(ShareFound& message);
  void take_over();
  void open_anew();
  void go_on();
  BeginShare beginning() const;  // for parts that are open, and have not been told
  void take(const TileDone& done);
  // `spec` as spec_bytes() has it: of many nodes it is made once.
  void prepare(NodeId node, const SharedBytes& spec);
  SharedBytes spec_bytes() const;
  void join(const NodeHandle& node);
  void leave(const NodeLeaves& leaves);
  bool leaves(const NodeHandle& node) const;
  void let_go();
  bool may_go(const NodeHandle& node);
  void dismiss(NodeId node);
  void left(const ShareEnded& message);
  void note(const NodeBack& back);
  bool knows(const NodeHandle& node) const;
  void welcome(NodeId node);
  NodeId add(const NodeHandle& node);
  void lose(const NodeHandle& node, Failure failure, const std::string& why);
  void lose_found(const NodeHandle& node);
  void lose(NodeId node, Failure failure, const std::string& why);
  void orphan_tiles(NodeId node, const std::string& why);
  bool nobody() const;
  void is_disturbed();
  void wait_for_a_node(Failure failure, const std::string& because = "no node is left");
  void give_up_waiting(const NobodyCame& over);
  void place_orphans();
  void change_table(const std::vector<Placement>& changes);
  const RoutingTable& table() const { return placements_.table(); }
  Placements::Lives lives() const {
    return [this](NodeId node) { return roster_.has(node); };
  }
  Host host(NodeId node, std::uint32_t threads, std::uint64_t memory_bytes) const;
  bool may_begin();
  bool has_room(NodeId node) const;
  void wait_for_room(const std::vector<TileId>& tiles);
  void missing(NodeId node, Failure failure, const std::string& why);
  void step_down() noexcept;
  std::vector<Host> hosts() const;
  std::set<NodeId> nodes() const;
  std::vector<caf::actor> part_handles() const;
  void finish_if_collected();
  void begin_next_stage();
  void act(QuiescenceDetector::Verdict verdict);
  void collect_if_settled();
  void show_progress(ShareProgress& message);
  void tell_progress();
  void count_tiles();
  void ended(ShareEnded& message);
  void fail(Failure failure);
  void give_up(Failure failure) noexcept;
  void abort_parts() noexcept;
  void lost_actor(const caf::down_msg& down);
  void finish_if_over() noexcept;
  // One message for many, for a table is as long as there are tiles: who changes what he gets makes his own of it.
  template <class Message>
  caf::message for_parts(Message message) const {
    static_assert(caf::response_type_unbox<caf::signatures_of_t<ShareHandle>, caf::detail::type_list<Message>>::valid);
    return caf::make_message(std::move(message));
  }
  void tell(const Participant& p, const caf::message& for_parts) {
    caf::actor_cast<caf::abstract_actor*>(p.part)->enqueue(caf::strong_actor_ptr(ctrl()), caf::make_message_id(),
                                                           for_parts, context());
  }
  template <class Message>
  void tell_parts(Message message) {
    const caf::message shared = for_parts(std::move(message));
    for (const Participant& p : parts_) {
      if (p.part) tell(p, shared);
    }
  }
  CoordinatorOptions options_;
  RunOwner& owner_;
  std::vector<Participant> parts_;  // by node
  Roster roster_;                   // likewise
  Placements placements_;
  Course course_;
  QuiescenceDetector detector_;
  std::vector<NodeHandle> asked_;  // for their parts, and have not answered
  std::vector<ShareFound> answers_;
  std::uint32_t numbers_lost_ = 0;  // below it are those of parts whose nodes were lost after they had answered
  struct Leaving {
    NodeHandle node;
    UsherHandle registry;
  };
  std::vector<Leaving> leaving_;  // nodes that are to leave, and are not let go yet
  bool without_room_ = false;     // no node has the memory for one of them
  Failure missed_;                // why the job fails if no node comes
  std::uint64_t waits_ = 0;       // for one, so far
  std::optional<Failure> failure_;
  Account account_{std::chrono::steady_clock::now()};
  std::optional<Epoch> counted_;
  bool told_ = false, again_ = false;
};

}  // namespace tessera

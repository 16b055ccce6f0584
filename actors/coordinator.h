// The coordinator of one job. It opens a share on every node, decides when all is quiet (two successive equal waves,
// src/exchange/detector.h), places the tiles of lost nodes again, and ends the job.
//
// state      | message          | effect                                                       | next
// finding    | ShareFound       | when all nodes have answered: a new table                    | the shares' state
// opening    | ShareOpened      | when all have: BeginShare to all                             | exchanging;
//            |                  |                                                              | collecting if settled
// exchanging | ShareIdle        | may begin a wave: Probe to every share                       | exchanging
// exchanging | ShareTally       | when two waves agree: Settle to all                          | settling
// settling   | ShareSettled     | when all have: mark the run settled, Collect to all          | collecting
// collecting | TileDone         | tell the owner of the run                                    | collecting
// collecting | ShareCollected   | when all have: the next stage begins, with a new table;      | exchanging;
//            |                  | after the last stage: Finish to all                          | finishing
// any        | NodeJoined       | open a share there; when it is open, Release to all others   |
// any        | NodeLeaves       | NodeLet, once there is nothing to do there (src/exchange/leaving.h)
// any        | ShareReleased    | a new epoch: the released tiles begin where work is wanted   |
// exchanging, settling | NodeLost | a new epoch: its tiles begin again on other nodes          | exchanging
// collecting | NodeLost         | a new epoch: others build its tiles that are not stored      | collecting
// any        | NodeLost, of the last node | wait for another node; fail when none comes within the grace | ending
// finding, exchanging, collecting | no node has the memory for a tile | the same (src/exchange/node_room.h)
// any        | a share is gone without a last message | as for NodeLost                        |
// any        | ShareProgress    | tell the owner the progress                                  |
// any        | Cancel           | Suspend to all shares                                        | ending
// any        | ShareEnded with a failure of its node's scratch, while there are other nodes | as for NodeLost
// exchanging | ShareEnded without a failure, of a node that leaves | a new epoch: its tiles go on elsewhere
// any        | ShareEnded       | with a failure: Abort to the others; when all have ended,    | ending;
//            |                  | the run has ended                                            | ended
// collecting | ShareEnded with damage | also: the run does not count as settled any more       | ending
// any        | an exception     | Abort to all shares                                          | ending
#pragma once

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
#include "src/exchange/inquiry.h"
#include "src/exchange/node_room.h"
#include "src/exchange/node_wait.h"
#include "src/exchange/placements.h"
#include "src/exchange/roster.h"
#include "src/exchange/share.h"

namespace tessera {

struct CoordinatorOptions {
  JobId job;
  ShareSpec spec;
  // By tile: how much work it is, in a unit of the job's own; 0: there is no such tile.
  std::vector<std::uint64_t> weights;
  std::vector<TileId> order;  // of the existing tiles: neighbours are near each other
  // The coordinator's term, which it has claimed. Of all coordinators of a job the one with the highest term is obeyed.
  // With `take_over` it takes over what an earlier coordinator has begun.
  Term term;
  bool take_over = false;
  std::uint32_t stages = 1;  // number of stages of the job
  // Writes down whether a stage is settled.
  std::function<Status(std::uint32_t stage, bool)> mark_settled;
  // Returns whether another coordinator has claimed a higher term. This one then says nothing any more, also when it
  // fails.
  std::function<bool()> replaced;
  // Used when taking over: is_settled() returns what mark_settled() has written, stored() the receipts of the tiles
  // that have come to the end of the stage.
  std::function<Result<bool>(std::uint32_t stage)> is_settled;
  std::function<Result<std::vector<TileReceipt>>(std::uint32_t stage)> stored;
  // Returns the stage with which the job begins when no node has a share of it: the last one that is settled.
  std::function<Result<std::uint32_t>()> first_stage;
  NodeRoom::WeightMax weight_max;
  NodeRoom::TileInWords tile_in_words;
  // When set, called at the moment when quiescence is believed. The harness checks there that it is true.
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
  // The actors of a node and its share. The roster has their state.
  struct Participant {
    NodeHandle node;
    ShareHandle share;  // null before the share is opened, and when it has ended
    Prepared<OpenShare> open;
    Prepared<Abort> abort;
  };
  // The actors of a node that was asked for its share, and of the share that it has. The inquiry has what they said.
  struct Asked {
    NodeHandle node;
    ShareHandle share;
  };
  // A node that is to leave, and was not let go yet.
  struct Leaving {
    NodeHandle node;
    UsherHandle registry;
  };

  void failed(const std::exception_ptr& exception) noexcept override;
  // Runs one step. A failure in it ends the job and not the coordinator, which waits for all shares.
  template <class Step>
  void attempt(Step step) noexcept;

  // The course of the job.
  void begin_if_opened();
  void begin();
  BeginShare beginning() const;  // for shares that are open, and have not begun
  void take(const TileDone& done);
  void act(QuiescenceDetector::Verdict verdict);
  void is_disturbed();
  void collect_if_settled();
  void finish_if_collected();
  void begin_next_stage();
  void change_table(const std::vector<Placement>& changes);
  void show_progress(ShareProgress& message);
  void tell_progress();

  // The end of the job.
  void ended(ShareEnded& message);
  void fail(Failure failure);
  void give_up(Failure failure) noexcept;
  void step_down() noexcept;
  void abort_shares() noexcept;
  void finish_if_over() noexcept;

  // The nodes; these are in coordinator_nodes.cc.
  void ask(const NodeHandle& node);
  void find(const NodeHandle& node);
  template <class Is>
  std::optional<Inquiry::Question> question_to(Is is) const;
  void found(ShareFound& message);
  void take_over();
  void open_anew();
  void forget_inquiry();
  void go_on();
  void join(const NodeHandle& node);
  NodeId add(const NodeHandle& node);
  bool knows(const NodeHandle& node) const;
  // Makes the messages for a node. `spec` is what spec_bytes() returns: all nodes share one copy.
  void prepare(NodeId node, const SharedBytes& spec);
  SharedBytes spec_bytes() const;
  void opened(const ShareOpened& message);
  void not_opened(const ShareOpened& message);
  void welcome(NodeId node);
  void note(const NodeBack& back);
  void leave(const NodeLeaves& leaves);
  bool leaves(const NodeHandle& node) const;
  void let_go();
  bool may_go(const NodeHandle& node);
  void dismiss(NodeId node);
  void left(const ShareEnded& message);
  void lost_actor(const caf::down_msg& down);
  void lose(const NodeHandle& node, Failure failure, const std::string& why);
  void lose_found(const NodeHandle& node);
  void lose(NodeId node, Failure failure, const std::string& why);
  void missing(NodeId node, Failure failure, const std::string& why);
  void lose_tiles(NodeId node, const std::string& why);
  void place_homeless();
  bool nobody() const;
  void wait_for_a_node(Failure failure, const std::string& because = "no node is left");
  void wait_for_room(const std::vector<TileId>& tiles);
  void give_up_waiting(const NobodyCame& over);

  const RoutingTable& table() const { return placements_.table(); }
  Placements::Lives lives() const {
    return [this](NodeId node) { return roster_.has(node); };
  }
  std::vector<Host> hosts() const;
  std::set<NodeId> nodes() const;
  std::vector<caf::actor> share_handles() const;
  // Makes one message for many shares, because a table is as long as there are tiles. A receiver that changes the
  // message gets a copy of its own.
  template <class Message>
  caf::message for_shares(Message message) const {
    static_assert(caf::response_type_unbox<caf::signatures_of_t<ShareHandle>, caf::detail::type_list<Message>>::valid);
    return caf::make_message(std::move(message));
  }
  void tell(const Participant& p, const caf::message& for_shares) {
    caf::actor_cast<caf::abstract_actor*>(p.share)->enqueue(caf::strong_actor_ptr(ctrl()), caf::make_message_id(),
                                                            for_shares, context());
  }
  template <class Message>
  void tell_shares(Message message) {
    const caf::message shared = for_shares(std::move(message));
    for (const Participant& p : participants_) {
      if (p.share) tell(p, shared);
    }
  }

  CoordinatorOptions options_;
  RunOwner& owner_;
  std::vector<Participant> participants_;  // by node
  std::vector<Asked> asked_;               // by question of the inquiry
  std::vector<Leaving> leaving_;
  Roster roster_;  // by node
  Placements placements_;
  Course course_;
  QuiescenceDetector detector_;
  Inquiry inquiry_;
  NodeRoom room_;
  NodeWait wait_;
  Account account_{std::chrono::steady_clock::now()};
  std::optional<Failure> failure_;  // why the job ends early
  bool again_ = false;              // as in RunEnded
  bool told_ = false;               // the owner was told that the run has ended
};

}  // namespace tessera

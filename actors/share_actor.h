// A node's part of a job: decides which of its tiles works next, within the job's share of memory and threads, and
// speaks for them.
//
// state      | message       | effect
// opened     | BeginShare     | grant work: first every tile begins, then those with most mail splay
// exchanging | MailNotice    | remember, grant if a thread is free
// exchanging | TileReport    | note the tile's counters, grant the next; tell the coordinator when all is idle
// exchanging | Probe         | answer with the sums of all tiles; idle only if no grant is out and no mail is known
// exchanging | Settle        | grant settle to every tile in memory; ShareSettled when all have
// opened, settling | Collect | grant collect to every tile that is not stored
// collecting | TileStored    | TileDone to the coordinator, grant the next; ShareCollected when every tile is stored
// collecting | Finish        | ShareEnded
// any        | Parcel        | hand its updates to the tiles; those of an epoch to come wait for its table
// any        | ChangeTable   | new tiles are fresh, the others hear of it (Rejoin); settling becomes exchanging.
//            |               | Of the next stage: all tiles leave, and others, of its program, are fresh
// any        | TileRejoined  | note the tile's counters; nothing is idle until all have said so
// opened, exchanging, collecting | Release | Leave to fresh tiles; when all have left: ShareReleased
// exchanging | HandOver      | grant hand over to every tile that has begun; ShareEnded when all are handed over
// any        | FindShare      | obey its sender from now on, if the term is a higher one; ShareFound, when no tile is
//            |               | about to leave; whoever hands over says ShareEnded
// any        | Suspend       | work under way stops, its tiles are given up; nothing but sleep is granted;
//            |               | ShareEnded (interrupted) when no tile is in memory
// any        | Abort, failed TileReport, TileFailed, the coordinator is gone
//                            | work under way stops; grant nothing more; ShareEnded with the first failure once
//                            | nothing is under way
// any        | Leave         | as Abort, but there is no ShareEnded
// any        | an exception  | ShareEnded with it; the tiles stop what they are at, and leave
//
// A tile's counters change only while it works under a grant, or goes by a new table, and both end in a report. So when
// neither is under way the part's copies are exact: its answer to a probe is a true snapshot of all its tiles.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "actors/actor_directory.h"
#include "actors/node_meter.h"
#include "actors/prepared.h"
#include "actors/protocol.h"
#include "actors/steady_actor.h"
#include "src/exchange/schedule.h"
#include "src/exchange/share.h"
#include "src/exchange/told_once.h"

namespace tessera {

inline std::string name_of(NodeId node) { return "node " + to_string(node); }

class ShareActor : public SteadyActor<ShareHandle, Pool::deciding> {
 public:
  // `progress_interval`: how often at most the coordinator, and the meter, hear of progress, where nodes are few.
  ShareActor(caf::actor_config& config, NodeId self, ShareOptions options, std::shared_ptr<const Share> part,
             CoordinatorHandle coordinator, Term term, Hooks hooks, std::chrono::milliseconds progress_interval,
             std::shared_ptr<NodeMeter> meter);
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  struct Hosted {
    TileHandle handle;
    Prepared<Leave> leave;
    Totals totals;
    ExchangeCounts items;
    std::uint64_t updates = 0, microseconds = 0;
    Epoch epoch;  // that it has last said it goes by
  };

  void failed(const std::exception_ptr& exception) noexcept override;
  void open(const BeginShare& begin);
  void change_table(ChangeTable& change);
  bool is_of_job(const RoutingTable& table, const std::vector<caf::actor>& parts) const;
  Failure not_of_job() const;
  void go_by(std::shared_ptr<const RoutingTable> table, const std::vector<caf::actor>& parts);
  void release(const Release& wanted);
  void begin_stage(const RoutingTable& table);
  void enter_collecting();
  // The coordinator, if there is one.
  template <class Message>
  void tell(Message message) {
    if (coordinator_) send(coordinator_, std::move(message));
  }
  void tell_stored(TileDone done);
  void obey(const FindShare& found);
  bool obeyed();
  // part_gates.cc
  void deliver(Packet& packet);
  void deliver(NodeId from, Update update);
  void keep_early(NodeId from, Update update);
  void deliver_early();
  void post(Update update);
  void send_parcels(NodeId to);
  void stop_for_gate(Error error);
  void give_credit(NodeId to, std::uint64_t bytes);
  void take(const Credit& credit);
  void close_gates();
  void end_gates();
  void take(TileReport& report);
  void take(TileStored& stored);
  void take(const TileRejoined& rejoined);
  void take(const TileLeft& left);
  void answer_if_left();
  void hand_over();
  void lost_coordinator(const caf::down_msg& down);
  void abandon(TileId tile, Failure failure);
  void stop(Failure failure);
  void stop_work() noexcept;
  void dispatch();
  void end();
  void tell_progress(bool now);
  void note(Hosted& tile, Totals totals);
  std::vector<std::uint64_t> weights_by(const RoutingTable& table) const;
  bool hosts(TileId tile) const { return hosted_.contains(tile); }
  const ShareStage& stage() const { return part_->stages.at(table_->stage); }
  // What an earlier process has stored of the stage at hand.
  std::span<const TileReceipt> stored_before() const {
    if (table_->stage != part_->table->stage) return {};
    return part_->stored;
  }
  const std::vector<std::uint64_t>& weights() const { return *part_->weights; }
  bool opened() const { return state_ != State::waiting; }
  bool idle() const { return opened() && rejoining_ == 0 && !failure_ && schedule_.idle(); }

  // What another node has sent, and does not know to be taken.
  struct Owed {
    std::uint64_t bytes = 0, held_back = 0;
  };

  NodeId self_;
  std::shared_ptr<const Share> part_;
  std::shared_ptr<ActorDirectory> office_;
  CoordinatorHandle coordinator_;
  Term term_;  // the coordinator's
  Schedule schedule_;
  std::map<TileId, Hosted> hosted_;
  std::uint32_t leaving_ = 0;        // tiles given up that are still there
  std::vector<TileId> given_up_;     // and what the coordinator has not been told of
  std::uint32_t releases_ = 0;       // that it waits for
  std::optional<FindShare> finder_;  // one that waits for an answer
  std::vector<TileDone> stored_;     // what a coordinator that takes over must hear again
  std::shared_ptr<const RoutingTable> table_;
  bool gate_failed_ = false;                            // its scratch could not be used
  std::vector<Delivery> early_;                         // of epochs whose table is still to come
  std::uint64_t early_bytes_ = 0;                       // of them, as Gate counts
  std::uint32_t rejoining_ = 0;                         // tiles that do not yet go by the table
  std::shared_ptr<const IncarnationChanges> rebirths_;  // since the oldest table that a tile goes by
  Totals totals_;                                       // sums over tiles
  std::map<NodeId, Outbox> outboxes_;
  std::map<NodeId, Owed> owed_;
  ShareEnded sum_;
  Prepared<ShareEnded> last_word_;
  ShareProgress progress_;  // of the stage at hand
  NodeWork before_;         // what was done in the stages before
  std::chrono::milliseconds progress_interval_;
  std::size_t nodes_ = 1;
  std::chrono::steady_clock::time_point progress_told_{};
  std::shared_ptr<NodeMeter> meter_;
  std::optional<Failure> failure_;
  enum class State : std::uint8_t { waiting, open, ended };  // for BeginShare; from there on; it has said its last word
  State state_ = State::waiting;
  bool silent_ = false;  // it leaves without a word
  ToldOnce said_;        // since its table, or its coordinator, is another one; that it is idle, since its last tally
};

}  // namespace tessera

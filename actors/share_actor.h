// A node's share of a job. It decides which of its tiles works next, within the job's memory and threads, and speaks
// for its tiles to the coordinator and to other nodes.
//
// state      | message       | effect
// opened     | BeginShare    | give permits: first every tile begins, then those with mail make steps (schedule.h)
// exchanging | MailNotice    | note it; give a permit if a thread is free
// exchanging | TileReport    | note the tile's counters; give the next permit; tell the coordinator when all is idle
// exchanging | Probe         | answer with the sums of all tiles; idle only if no permit is out and no mail is known
// exchanging | Settle        | permit to settle for every tile in memory; ShareSettled when all have settled
// opened, settling | Collect | permit to finish for every tile that is not stored
// collecting | TileStored    | TileDone to the coordinator; the next permit; ShareCollected when every tile is stored
// collecting | Finish        | ShareEnded
// any        | Packet        | pass its updates to the tiles; updates of an epoch to come wait for its table
// any        | ChangeTable   | new tiles are fresh, the others are told (Rejoin); settling becomes exchanging. With a
//            |               | table of the next stage all tiles leave, and others, of its program, are fresh
// any        | TileRejoined  | note the tile's counters; the share is not idle before all tiles have said this
// opened, exchanging, collecting | Release | Leave to fresh tiles; when all have left: ShareReleased
// exchanging | HandOver      | permit to hand over for every tile that has begun; ShareEnded when all have
// any        | FindShare     | with a higher term: obey the sender from now on; ShareFound once no tile is about to
//            |               | leave. A share that hands over sends ShareEnded instead
// any        | Suspend       | stop work under way, and give up its tiles; permits for sleep only; ShareEnded
//            |               | (interrupted) when no tile is in memory
// any        | Abort, failed TileReport, TileFailed, the coordinator is gone
//            |               | stop work under way; no more permits; ShareEnded with the first failure once no work is
//            |               | under way. A coordinator may be gone for the grace before that
// any        | Leave         | as for Abort, but without ShareEnded
// any        | an exception  | ShareEnded with it; the tiles stop their work, and leave
//
// A tile's counters change only while it works under a permit, or takes a new table, and both end in a report. So when
// neither is under way, the share's copies are exact, and its answer to a probe is a true snapshot of all its tiles.
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
#include "actors/share_account.h"
#include "actors/steady_actor.h"
#include "src/exchange/followed_table.h"
#include "src/exchange/outboxes.h"
#include "src/exchange/schedule.h"
#include "src/exchange/share.h"
#include "src/exchange/tile_releases.h"
#include "src/exchange/told_once.h"

namespace tessera {

inline std::string name_of(NodeId node) { return "node " + to_string(node); }

class ShareActor : public SteadyActor<ShareHandle, Pool::deciding> {
 public:
  // `progress_interval` is the shortest time between two progress messages to the coordinator and the meter. It grows
  // with the number of nodes when they are many.
  ShareActor(caf::actor_config& config, NodeId self, ShareOptions options, std::shared_ptr<const Share> share,
             CoordinatorHandle coordinator, Term term, Hooks hooks, std::chrono::milliseconds progress_interval,
             std::shared_ptr<NodeMeter> meter);
  behavior_type make_behavior() override;
  void on_exit() override;

 private:
  struct Hosted {
    TileHandle handle;
    Prepared<Leave> leave;
    ShareAccount::Tile counts;
    Epoch epoch;  // the epoch by which the tile last said that it goes
  };

  void failed(const std::exception_ptr& exception) noexcept override;
  void open(const BeginShare& begin);
  void change_table(ChangeTable& change);
  bool is_of_job(const RoutingTable& table, const std::vector<caf::actor>& shares) const;
  Failure not_of_job() const;
  void go_by(std::shared_ptr<const RoutingTable> table, const std::vector<caf::actor>& shares);
  void release(const Release& wanted);
  void begin_stage(const RoutingTable& table);
  void enter_collecting();
  // Sends to the coordinator, if there is one.
  template <class Message>
  void tell(Message message) {
    if (coordinator_) send(coordinator_, std::move(message));
  }
  void tell_stored(TileDone done);
  void obey(const FindShare& found);
  bool obeyed();
  void deliver(Packet& packet);
  void deliver(NodeId from, Update update);
  void keep_early(NodeId from, Update update);
  void deliver_early();
  void post(Update update);
  void send_packets(NodeId to);
  void stop_for_outbox(Error error);
  void give_credit(NodeId to, std::uint64_t bytes);
  void take(const Credit& credit);
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
  bool hosts(TileId tile) const { return hosted_.contains(tile); }
  const ShareStage& stage() const { return share_->stages.at(table_->stage); }
  // The tiles of the present stage that an earlier process has stored.
  std::span<const TileReceipt> stored_before() const {
    if (table_->stage != share_->table->stage) return {};
    return share_->stored;
  }
  const std::vector<std::uint64_t>& weights() const { return *share_->weights; }
  bool opened() const { return state_ != State::waiting; }
  bool idle() const { return opened() && table_.is_taken() && !failure_ && schedule_.idle(); }

  NodeId self_;
  std::shared_ptr<const Share> share_;
  std::shared_ptr<ActorDirectory> directory_;
  CoordinatorHandle coordinator_;
  Term term_;  // the coordinator's
  Schedule schedule_;
  std::map<TileId, Hosted> hosted_;
  FollowedTable table_;
  TileReleases releases_;
  std::optional<FindShare> finder_;  // the request that waits for its ShareFound
  std::vector<TileDone> stored_;     // a coordinator that takes over must hear these again
  EarlyMail early_;
  Outboxes outboxes_;
  OwedCredit owed_;
  ShareAccount account_;
  std::size_t nodes_ = 1;
  std::shared_ptr<NodeMeter> meter_;
  Prepared<ShareEnded> last_message_;
  std::optional<Failure> failure_;
  // Waiting for BeginShare; at work; its last message is made.
  enum class State : std::uint8_t { waiting, open, ended };
  State state_ = State::waiting;
  bool outbox_failed_ = false;  // the scratch of an outbox could not be used
  bool silent_ = false;         // the share ends without a last message
  // What was said since the last table or coordinator; and since the last tally, that it is idle.
  ToldOnce said_;
};

}  // namespace tessera

// The messages between actors. None of them contains a pointer to memory that another process would not get. None
// contains a double: CAF's codec for doubles is not exact (-0, denormals), and never ends for infinity. Coordinates
// travel as raw bytes, times as whole microseconds.
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/base/figures.h"
#include "src/base/ids.h"
#include "src/base/mail_arcs.h"
#include "src/base/result.h"
#include "src/exchange/assignment.h"
#include "src/exchange/outbox.h"
#include "src/exchange/routing_table.h"
#include "src/exchange/tile_program.h"
#include "src/exchange/update.h"
#include "src/exchange/work.h"

namespace tessera {

// An error on its way to another actor. Code 0: no error.
struct Failure {
  std::uint8_t code = 0;  // an Errc
  std::string text;
  explicit operator bool() const { return code != 0; }
};
inline Failure failure_of(Error e) { return {static_cast<std::uint8_t>(e.code), std::move(e.where)}; }
inline Error error_of(Failure f) { return error(static_cast<Errc>(f.code), std::move(f.text)); }

// share -> tile: do this work. Answered by a TileReport.
struct Permit {
  Work work = Work::step;
};

// tile -> share: what waits for the tile, after more mail has come. `memory` in bytes; `hops` as in Schedule::Waiting.
struct MailNotice {
  TileId tile;
  std::uint64_t updates = 0, bytes = 0, memory = 0;
  std::uint32_t hops = 0;
};

// One piece of work on a tile: its times, in microseconds since the share was opened, and the thread of the node.
struct WorkSpan {
  TileId tile;
  Work work = Work::step;
  std::uint32_t thread = 0;
  std::uint64_t begin_us = 0, end_us = 0;
};

// tile -> share: the work is done, or has failed.
struct TileReport {
  WorkSpan span;
  Failure failure;
  bool kept = true;           // false: the tile was to be handed over, and its image could not be written
  std::uint64_t memory = 0;   // bytes that the tile holds, without mail
  std::uint64_t storing = 0;  // bytes on their way to the store
  MailNotice waiting;
  std::uint64_t sent = 0, processed = 0;  // updates, summed over living peers
  std::uint64_t updates = 0;              // ever sent
  std::uint32_t hops = 0;
  ExchangeCounts items;
};

// tile -> share, at any time: the tile has ended without being told to.
struct TileFailed {
  TileId tile;
  Failure failure;
};

// writer -> share, some time after a tile was collected: what it leaves is kept, or could not be.
struct TileStored {
  TileId tile;
  Failure failure;
  Receipt receipt;
};

// tile -> share: an update for a tile on another node.
struct Outgoing {
  Update update;
};
// share -> share of another node: updates for tiles there.
struct Packet {
  NodeId from;
  std::uint64_t window_bytes = 0;  // of the sender's outbox
  std::vector<Update> updates;
};
// share -> tile: an update. For an update from another node the tile answers with Taken when it is in the mail.
struct Delivery {
  NodeId from;
  Update update;
};
struct Taken {
  NodeId from;
  std::uint64_t bytes = 0;  // as Outbox counts them
};
// share -> share of another node: so many bytes of what that share has sent are in the mail of tiles, or were dropped.
struct Credit {
  NodeId from;
  std::uint64_t bytes = 0;
};

// share -> tile: there is a new table (src/exchange/routing_table.h). Answered by a TileRejoined, at once.
struct Rejoin {};
// tile -> share: the tile goes by this table.
struct TileRejoined {
  TileId tile;
  Epoch epoch;
  std::uint64_t sent = 0, processed = 0;  // updates, summed over living peers
  MailNotice waiting;
};

// tile -> share: nothing of the tile is left on scratch, and nothing will be.
struct TileLeft {
  TileId tile;
};

// Bytes that many messages have in common. A process holds them once, but each message on the wire has them.
class SharedBytes {
 public:
  SharedBytes(std::string bytes = {}) : bytes_(std::make_shared<const std::string>(std::move(bytes))) {}
  const std::string& get() const { return *bytes_; }

 private:
  std::shared_ptr<const std::string> bytes_;
};

// coordinator -> node: open a share with these tiles. `spec` is a ShareSpec as bytes; its length grows with the number
// of tiles.
struct OpenShare {
  JobId job;
  NodeId node;  // the node's number in this job
  SharedBytes spec;
  caf::actor coordinator;
  Term term;
};

// coordinator that takes over -> node, which passes it on to its share of the job: obey me. Each term is claimed by one
// coordinator, and a share obeys the highest term that it has heard of.
struct FindShare {
  JobId job;
  Term term;
  caf::actor node;  // the node that is asked
  caf::actor coordinator;
  std::uint32_t shares = 1;  // as in ShareSpec
  std::string name = {};     // of the node, which sets it
};
// node, or its share -> that coordinator
struct ShareFound {
  Term term;
  caf::actor node;
  caf::actor share;    // null: there is no share; then only term, node, name, and what a share would get, are set
  NodeId self;         // the node's number in this job
  bool begun = false;  // BeginShare has come
  RoutingTable table;
  // Its tiles by the table that it has given up; perhaps the coordinator before was not told.
  std::vector<TileId> released;
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
  std::string name;
};

// coordinator -> share. Each epoch has one table.
struct BeginShare {
  std::vector<caf::actor> shares;  // by node; null where there is none
  RoutingTable table;
  bool settled = false;  // all shares are settled: collect at once
};
struct ChangeTable {
  RoutingTable table;
  std::vector<caf::actor> shares;  // by node
  bool settled = false;            // new tiles are collected at once
};
struct Probe {
  Wave wave;
};
struct Settle {};
struct Collect {};
struct Finish {};  // all tiles of all shares are stored
struct Suspend {};
struct Abort {
  Term term;  // of the coordinator that sends it
};
// Give up tiles that have not begun, until they weigh `weight` together, because another node waits for work. Answered
// by a ShareReleased.
struct Release {
  std::uint64_t weight = 0;
};

// The share's node leaves: hand over the tiles that have begun, so that others go on with them. Answered by a
// ShareEnded.
struct HandOver {};

// node -> coordinator
struct ShareOpened {
  NodeId node;
  Failure failure;
  caf::actor share;
  bool settled = false;  // the share needs no exchange
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
  std::string name;  // of the node in its cluster
};
// share -> coordinator
struct ShareBegun {  // all its tiles have begun
  NodeId node;
};
struct ShareIdle {
  NodeId node;
};
struct ShareTally {
  NodeId node;
  Epoch epoch;
  Wave wave;
  bool idle = false;
  std::uint64_t sent = 0, processed = 0;
};
struct ShareSettled {
  NodeId node;
  Epoch epoch;
};
struct ShareCollected {  // all its tiles are stored
  NodeId node;
  Epoch epoch;
};
struct ShareReleased {
  NodeId node;
  std::vector<TileId> tiles;  // they are not on the node any more
};
struct ShareProgress {
  NodeId node;
  std::uint64_t tiles_begun = 0, weight_begun = 0, tiles_stored = 0, tiles_asleep = 0;
  std::uint64_t updates_sent = 0, updates_processed = 0, items_sent = 0, memory_bytes = 0;
  OutboxCounts outboxes;
  std::vector<WorkSpan> spans;  // since the message before
  std::vector<MailArc> mail;    // likewise; the largest ones
};
// share -> coordinator: what a tile leaves is kept.
struct TileDone {
  std::uint32_t stage = 0;
  TileReceipt tile;
  std::uint64_t microseconds = 0;  // time of work on the tile
};
struct ShareEnded {
  NodeId node;
  Failure failure;
  bool of_node = false;  // the failure is that of the node's own scratch, so that other nodes can go on
  ExchangeCounts items;
  std::uint64_t updates = 0, hops = 0, sleeps = 0, most_received = 0;
  std::uint64_t begin_us = 0, exchange_us = 0, collect_us = 0;  // time of work, summed over threads
  OutboxCounts outboxes;                                        // for what was sent to other nodes
  std::uint64_t handed = 0, not_handed = 0;                     // tiles that had begun when the node was told to leave
};

// owner of the run -> coordinator
struct Cancel {};
// registry -> coordinator: the node is lost, and never comes back; or it is there, and free for work.
struct NodeLost {
  caf::actor node;
  std::string why = {};  // "has been silent for longer than its lease"
};
struct NodeJoined {
  caf::actor node;
};
// The node is to leave, and gets no more work. Answer with NodeLet to `registry` when there is nothing to do there any
// more.
struct NodeLeaves {
  caf::actor node, registry;
};
// The node's process is back, as another node. `last_words` says how the process before it ended.
struct NodeBack {
  std::string name, last_words;
};
// coordinator or router -> registry: `follower` does not need the node any more.
struct NodeLet {
  caf::actor node, follower;
};

// coordinator -> itself: the job has been without a node for its grace.
struct NobodyCame {
  std::uint64_t wait = 0;  // number of the wait, which tells it from earlier ones
};

// router -> node: route this split of the input (src/tiling/split_router.h), with 1/`shares` of the node's threads and
// memory. The node stops when the router is gone.
struct RouteSplit {
  std::string run_folder;
  std::uint32_t split = 0, attempt = 0, shares = 1;
  caf::actor router;
};
// node -> router, now and then, and at the end
struct SplitRouted {
  std::uint32_t attempt = 0;
  std::uint64_t routed = 0;  // how much of the split is routed so far
  bool done = false;
  Failure failure;
};

// share -> itself: no coordinator has taken over within the grace.
struct GraceOver {
  Term term;
};

// share -> tile, node -> share, the process -> its node: end. What still waits for the receiver is not wanted any more.
struct Leave {
  // For a fresh tile that begins on another node: remove what waits on scratch, too, and answer with a TileLeft.
  bool given_up = false;
};

using TileHandle =
    caf::typed_actor<caf::reacts_to<Delivery>, caf::reacts_to<Permit>, caf::reacts_to<Rejoin>, caf::reacts_to<Leave>>;
using ShareHandle = caf::typed_actor<
    caf::reacts_to<BeginShare>, caf::reacts_to<ChangeTable>, caf::reacts_to<Finish>, caf::reacts_to<FindShare>,
    caf::reacts_to<HandOver>, caf::reacts_to<Release>, caf::reacts_to<TileRejoined>, caf::reacts_to<Probe>,
    caf::reacts_to<Settle>, caf::reacts_to<Collect>, caf::reacts_to<Suspend>, caf::reacts_to<Abort>,
    caf::reacts_to<Packet>, caf::reacts_to<Outgoing>, caf::reacts_to<Taken>, caf::reacts_to<Credit>,
    caf::reacts_to<MailNotice>, caf::reacts_to<TileReport>, caf::reacts_to<TileFailed>, caf::reacts_to<TileStored>,
    caf::reacts_to<TileLeft>, caf::reacts_to<GraceOver>, caf::reacts_to<Leave>>;
// The network between tiles in the harness. It takes a packet and the share that it is for.
using NetworkHandle = caf::typed_actor<caf::reacts_to<caf::actor, Packet>, caf::reacts_to<caf::tick_atom>>;
using NodeHandle = caf::typed_actor<caf::reacts_to<OpenShare>, caf::reacts_to<FindShare>, caf::reacts_to<RouteSplit>,
                                    caf::reacts_to<Leave>>;
// An actor that is told of nodes that come and go.
using FollowerHandle = caf::typed_actor<caf::reacts_to<NodeLost>, caf::reacts_to<NodeJoined>,
                                        caf::reacts_to<NodeLeaves>, caf::reacts_to<NodeBack>>;
// The actor that has asked for a node to leave.
using UsherHandle = caf::typed_actor<caf::reacts_to<NodeLet>>;
using RouterHandle = caf::typed_actor<caf::reacts_to<SplitRouted>, caf::reacts_to<NodeLost>, caf::reacts_to<NodeJoined>,
                                      caf::reacts_to<NodeLeaves>, caf::reacts_to<NodeBack>, caf::reacts_to<Cancel>>;
using CoordinatorHandle =
    caf::typed_actor<caf::reacts_to<ShareOpened>, caf::reacts_to<ShareFound>, caf::reacts_to<ShareBegun>,
                     caf::reacts_to<ShareIdle>, caf::reacts_to<ShareTally>, caf::reacts_to<ShareSettled>,
                     caf::reacts_to<ShareCollected>, caf::reacts_to<ShareReleased>, caf::reacts_to<NodeLost>,
                     caf::reacts_to<NodeJoined>, caf::reacts_to<NodeLeaves>, caf::reacts_to<NodeBack>,
                     caf::reacts_to<NobodyCame>, caf::reacts_to<ShareProgress>, caf::reacts_to<TileDone>,
                     caf::reacts_to<ShareEnded>, caf::reacts_to<Cancel>>;

}  // namespace tessera

#include "actors/protocol_inspect.h"

// What actors say to each other. Nothing here refers to memory that another process would not get, and nothing holds a
// double: CAF's codec for them is not exact (-0, denormals) and does not end on infinity; coordinates travel as raw
// bytes, times as whole microseconds.
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

// An error on its way. ok: none.
struct Failure {
  std::uint8_t code = 0;  // an Errc
  std::string text;
  explicit operator bool() const { return code != 0; }
};
inline Failure failure_of(Error e) { return {static_cast<std::uint8_t>(e.code), std::move(e.where)}; }
inline Error error_of(Failure f) { return error(static_cast<Errc>(f.code), std::move(f.text)); }

// part -> tile: do this now; answered by a TileReport.
struct Permit {
  Work work = Work::step;
};

// tile -> part: what waits for it, since more has come.
struct MailNotice {
  TileId tile;
  std::uint64_t updates = 0, bytes = 0, memory = 0;
  std::uint32_t hops = 0;
};

// A piece of work on a tile: when, in microseconds since the part was opened, and by which thread of its node.
struct WorkSpan {
  TileId tile;
  Work work = Work::step;
  std::uint32_t thread = 0;
  std::uint64_t begin_us = 0, end_us = 0;
};

// tile -> part: the work is done, or has failed.
struct TileReport {
  WorkSpan span;
  Failure failure;
  bool kept = true;           // false: it was to be handed over, and could not be
  std::uint64_t memory = 0;   // held, mail not counted
  std::uint64_t storing = 0;  // bytes that are on their way to the store
  MailNotice waiting;
  std::uint64_t sent = 0, processed = 0;  // updates, per living peers
  std::uint64_t updates = 0;              // ever sent
  std::uint32_t hops = 0;
  ExchangeCounts items;
};

// tile -> part, at any time: the tile has come to an end that nobody asked for.
struct TileFailed {
  TileId tile;
  Failure failure;
};

// writer -> part, some time after a tile has been collected: what it leaves is kept, or could not be.
struct TileStored {
  TileId tile;
  Failure failure;
  Receipt receipt;
};

// tile -> part: for a tile that lives elsewhere.
struct Outgoing {
  Update update;
};
// part -> part of another node: updates for tiles that live there.
struct Packet {
  NodeId from;
  std::uint64_t window_bytes = 0;  // of the sender's gate
  std::vector<Update> updates;
};
// part -> tile. Of what another node has sent the part hears when it is in the tile's mail (Taken).
struct Delivery {
  NodeId from;
  Update update;
};
struct Taken {
  NodeId from;
  std::uint64_t bytes = 0;  // as Gate counts them
};
// part -> part of another node: so many bytes of what that has sent are in the mail of tiles, or dropped.
struct Credit {
  NodeId from;
  std::uint64_t bytes = 0;
};

// part -> tile: there is a new table (src/exchange/assignment.h); answered by a TileRejoined, at once.
struct Rejoin {};
// tile -> part: it goes by this table.
struct TileRejoined {
  TileId tile;
  Epoch epoch;
  std::uint64_t sent = 0, processed = 0;  // updates, per living peers
  MailNotice waiting;
};

// tile -> part: nothing of it is left on scratch, and nothing will be.
struct TileLeft {
  TileId tile;
};

// What many messages say: on the wire in each, in a process once.
class SharedBytes {
 public:
  SharedBytes(std::string bytes = {}) : bytes_(std::make_shared<const std::string>(std::move(bytes))) {}
  const std::string& get() const { return *bytes_; }

 private:
  std::shared_ptr<const std::string> bytes_;
};

// coordinator -> node: host these tiles. `spec`: a ShareSpec as bytes, which are as many as there are tiles.
struct OpenShare {
  JobId job;
  NodeId node;  // the number that the node has in this job
  SharedBytes spec;
  caf::actor coordinator;
  Term term;
};

// a coordinator that takes over -> node, which passes it on to its part of the job: obey me. Terms are claimed, each by
// one coordinator; a part obeys that of the highest term it has heard of.
struct FindShare {
  JobId job;
  Term term;
  caf::actor node;  // that is asked
  caf::actor coordinator;
  std::uint32_t shares = 1;  // as in ShareSpec
  std::string name = {};     // of the node, by itself
};
// node, or its part -> that coordinator
struct ShareFound {
  Term term;
  caf::actor node;
  caf::actor part;     // null: there is none; the rest, but what it would have, then says nothing
  NodeId self;         // the number that the node has in this job
  bool begun = false;  // BeginShare has come
  RoutingTable table;
  std::vector<TileId> released;  // by the table its own, and given up: nobody may have heard of it
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
  std::string name;
};

// coordinator -> part. Each epoch has one table.
struct BeginShare {
  std::vector<caf::actor> parts;  // by node; null where there is none
  RoutingTable table;
  bool settled = false;  // of all parts: collect at once
};
struct ChangeTable {
  RoutingTable table;
  std::vector<caf::actor> parts;  // by node
  bool settled = false;           // what is new is collected at once
};
struct Probe {
  Wave wave;
};
struct Settle {};
struct Collect {};
struct Finish {};  // all tiles of all parts are stored
struct Suspend {};
struct Abort {
  Term term;  // of the coordinator that says so
};
// Give up tiles that nobody has begun, until they have so much weight: another node is waiting for work. Answered by a
// ShareReleased.
struct Release {
  std::uint64_t weight = 0;
};

// Your node leaves: tiles that have begun are handed over, for others to go on with. Answered by a ShareEnded.
struct HandOver {};

// node -> coordinator
struct ShareOpened {
  NodeId node;
  Failure failure;
  caf::actor part;
  bool settled = false;  // needs no exchange
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
  std::string name;  // of the node in its cluster
};
// part -> coordinator
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
  std::vector<TileId> tiles;  // not its own any more
};
struct ShareProgress {
  NodeId node;
  std::uint64_t tiles_begun = 0, weight_begun = 0, tiles_stored = 0, tiles_asleep = 0;
  std::uint64_t updates_sent = 0, updates_processed = 0, items_sent = 0, memory_bytes = 0;
  OutboxCounts outboxes;
  std::vector<WorkSpan> spans;  // since the last one
  std::vector<MailArc> mail;    // likewise; the heaviest
};
// part -> coordinator: what a tile leaves is kept.
struct TileDone {
  std::uint32_t stage = 0;
  TileReceipt tile;
  std::uint64_t microseconds = 0;  // worked on it
};
struct ShareEnded {
  NodeId node;
  Failure failure;
  bool of_node = false;  // the failure: its own scratch cannot be used, and others can go on
  ExchangeCounts items;
  std::uint64_t updates = 0, hops = 0, sleeps = 0, most_received = 0;
  std::uint64_t begin_us = 0, exchange_us = 0, collect_us = 0;  // of work, summed over threads
  OutboxCounts outboxes;                                        // of what was sent to other nodes
  std::uint64_t handed = 0, not_handed = 0;                     // tiles that it had begun, when its node leaves
};

// whoever runs the job -> coordinator
struct Cancel {};
// whoever keeps count of nodes -> coordinator: it is lost, and never comes back; it is there, and free.
struct NodeLost {
  caf::actor node;
  std::string why = {};  // "has not been heard of for 10 s"
};
struct NodeJoined {
  caf::actor node;
};
// It is to leave, and takes no more work: say NodeLet to `registry` when nothing is to be done there any more.
struct NodeLeaves {
  caf::actor node, registry;
};
// Its process is back, as another node: how the one before it ended.
struct NodeBack {
  std::string name, last_words;
};
// whoever uses nodes -> whoever keeps count of them
struct NodeLet {
  caf::actor node, follower;
};

// coordinator -> itself: the job has been without a node for its grace.
struct NobodyCame {
  std::uint64_t wait = 0;  // the how many-th of the job
};

// router -> node: route this stretch of the input (src/delaunay/run/routing.h), with one of so many shares of your
// threads and memory. Done or not, it is given up when the router is gone.
struct RouteSplit {
  std::string run_folder;
  std::uint32_t split = 0, attempt = 0, shares = 1;
  caf::actor router;
};
// node -> router, now and then, and at the end
struct SplitRouted {
  std::uint32_t attempt = 0;
  std::uint64_t routed = 0;  // of what the stretch has, so far
  bool done = false;
  Failure failure;
};

// part -> itself: nobody has taken over.
struct GraceOver {
  Term term;
};

// part -> tile, node -> part, whoever has started a node -> node: come to an end. What waits for you is not wanted any
// more.
struct Leave {
  // To a tile that is fresh, and begins on another node: remove what waits on scratch, too, and answer with a TileLeft.
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
// What stands between tiles in the harness: a parcel, and the part that it is for.
using NetworkHandle = caf::typed_actor<caf::reacts_to<caf::actor, Packet>, caf::reacts_to<caf::tick_atom>>;
using NodeHandle = caf::typed_actor<caf::reacts_to<OpenShare>, caf::reacts_to<FindShare>, caf::reacts_to<RouteSplit>,
                                    caf::reacts_to<Leave>>;
// Whoever hears of nodes that come and go.
using FollowerHandle = caf::typed_actor<caf::reacts_to<NodeLost>, caf::reacts_to<NodeJoined>,
                                        caf::reacts_to<NodeLeaves>, caf::reacts_to<NodeBack>>;
// Whoever has asked for nodes that are to leave.
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

// What a share sends to other nodes and gets from them, within credit (src/exchange/outbox.h).
#include <algorithm>
#include <utility>

#include "actors/failing.h"
#include "actors/share_actor.h"

namespace tessera {
namespace {

constexpr std::uint32_t nodes_max = 1 << 16;

}  // namespace

// An error io is that of the node's own scratch, because what waits for other nodes lies there.
void ShareActor::stop_for_gate(Error error) {
  gate_failed_ = error.code == Errc::io;
  stop(failure_of(std::move(error)));
}

// Sends an update to the node that has the tile by the newest table. Drops it when the tile has another incarnation
// there.
void ShareActor::post(Update update) {
  if (failure_ || !table_->alive(update.to)) return;
  const NodeId to = table_->node_of(update.to.tile);
  if (to == self_) return deliver(self_, std::move(update));
  // That node is lost. A table to come says where the tile is.
  if (!office_->routes()->part_of(to)) return;
  Outbox& outbox = outboxes_
                       .try_emplace(to, part_->outboxes,
                                    part_->scratch.empty() ? part_->scratch : outbox_scratch_file(part_->scratch, to))
                       .first->second;
  if (Status added = outbox.add(std::move(update)); !added) {
    stop_for_gate(std::move(added).error());
    return dispatch();
  }
  send_parcels(to);
}

void ShareActor::send_parcels(NodeId to) {
  const ShareHandle there = office_->routes()->part_of(to);
  Outbox& outbox = outboxes_.at(to);
  while (true) {
    auto updates = outbox.next();
    if (!updates) {
      stop_for_gate(std::move(updates).error());
      return dispatch();
    }
    if (updates.value().empty()) return;
    Packet packet{self_, part_->outboxes.window_bytes, std::move(updates).value()};
    if (office_->hooks.network) {
      send(office_->hooks.network, caf::actor_cast<caf::actor>(there), std::move(packet));
    } else {
      send(there, std::move(packet));
    }
  }
}

void ShareActor::deliver(Packet& packet) {
  if (packet.from.value >= nodes_max) {  // something is kept for each node
    stop(failure_of(error(Errc::internal, name_of(self_) + " got mail of node " + std::to_string(packet.from.value) +
                                              ", which no job has")));
    return dispatch();
  }
  if (packet.from != self_) owed_[packet.from].held_back = Outbox::held_back(packet.window_bytes);
  for (Update& update : packet.updates) deliver(packet.from, std::move(update));
}

// Up to twice as many nodes may send as the newest table has, because others join. The bound is there because a node
// that ignores its window could otherwise fill the memory.
void ShareActor::keep_early(NodeId from, Update update) {
  early_bytes_ += Outbox::bytes_of(update);
  early_.push_back({from, std::move(update)});
  if (early_bytes_ <= 2 * std::max<std::size_t>(nodes_, 8) * in_flight_max) return;
  stop(failure_of(error(Errc::internal, name_of(self_) + " got " + std::to_string(early_bytes_) +
                                            " bytes of mail by tables that did not come, more than nodes send")));
  dispatch();
}

void ShareActor::deliver_early() {
  early_bytes_ = 0;
  for (Delivery& early : std::exchange(early_, {})) deliver(early.from, std::move(early.update));
}

// Whatever another node sends, it never ends this process: an update for a tile that does not exist ends the job.
void ShareActor::deliver(NodeId from, Update update) {
  if (failure_) return;  // mail of a job that is over
  const auto routes = office_->routes();
  if (!routes || update.epoch > table_->epoch) return keep_early(from, std::move(update));
  const TileId to = update.to.tile;
  const std::size_t tiles = weights().size();
  const bool sound = to.value < tiles && update.from.tile.value < tiles;
  // The update was sent by an older table; or the tile was given up, and its next incarnation is told again.
  const TileHandle handle = routes->tile(to);
  const bool gone = sound && (!table_->alive(update.to) || (handle && !hosts(to)));
  if (gone) return give_credit(from, Outbox::bytes_of(update));
  if (!sound || !handle) {
    stop(failure_of(error(Errc::internal, name_of(self_) + " got mail for tile " + std::to_string(to.value) +
                                              ", which it does not have")));
    return dispatch();
  }
  send(handle, Delivery{from, std::move(update)});
}

// Credit is not sent for each packet. What is owed is always so little that the other node can go on sending.
void ShareActor::give_credit(NodeId to, std::uint64_t bytes) {
  if (to == self_ || failure_) return;
  Owed& owed = owed_[to];
  owed.bytes += bytes;
  if (owed.bytes < owed.held_back) return;
  if (const ShareHandle there = office_->routes()->part_of(to))
    send(there, Credit{self_, std::exchange(owed.bytes, 0)});
}

void ShareActor::take(const Credit& credit) {
  const auto outbox = outboxes_.find(credit.from);
  if (outbox == outboxes_.end() || failure_) return;
  outbox->second.taken(credit.bytes);
  send_parcels(credit.from);
}

// Empties the outboxes to nodes that are lost.
void ShareActor::close_gates() {
  const auto routes = office_->routes();
  for (auto& [node, outbox] : outboxes_) {
    if (!routes->part_of(node)) outbox.clear();
  }
}

void ShareActor::end_gates() {
  for (auto& [node, outbox] : outboxes_) outbox.clear();
}

}  // namespace tessera

// How CAF reads and writes the messages of protocol.h, and their names on the wire.
#pragma once

#include <caf/all.hpp>
#include <type_traits>

#include "actors/inspect_message.h"
#include "actors/protocol.h"

namespace tessera {

template <class Inspector, class Tag, class Rep>
typename Inspector::result_type inspect(Inspector& f, Id<Tag, Rep>& x) {
  return f(x.value);
}

template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, Epoch& x) {
  return f(x.term, x.number);
}

template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, Incarnation& x) {
  return f(x.term, x.number);
}

template <class Inspector>
typename Inspector::result_type inspect(Inspector& f, SharedBytes& x) {
  std::string bytes = x.get();
  const auto load = [&]() -> caf::error {
    x = SharedBytes(std::move(bytes));
    return caf::none;
  };
  return f(bytes, caf::meta::load_callback(load));
}

TESSERA_MESSAGE(Failure, x.code, x.text)
TESSERA_MESSAGE(ExchangeCounts, x.received, x.inserted, x.refused, x.sent, x.useful)
TESSERA_MESSAGE(MailArc, x.from, x.to, x.bytes)
TESSERA_MESSAGE(WorkSpan, x.tile, x.work, x.thread, x.begin_us, x.end_us)
TESSERA_MESSAGE(OutboxCounts, x.packets, x.bytes, x.waits)
TESSERA_MESSAGE(Credit, x.from, x.bytes)
TESSERA_MESSAGE(OpenShare, x.job, x.node, x.spec, x.coordinator, x.term)
TESSERA_MESSAGE(RoutingTable, x.epoch, x.stage, x.nodes, x.incarnations)
TESSERA_MESSAGE(FindShare, x.job, x.term, x.node, x.coordinator, x.shares, x.name)
TESSERA_MESSAGE(ShareFound, x.term, x.node, x.share, x.self, x.begun, x.table, x.released, x.threads, x.memory_bytes,
                x.name)
TESSERA_MESSAGE(BeginShare, x.shares, x.table, x.settled)
TESSERA_MESSAGE(ChangeTable, x.table, x.shares, x.settled)
TESSERA_MESSAGE(Probe, x.wave)
TESSERA_MESSAGE(Settle)
TESSERA_MESSAGE(Collect)
TESSERA_MESSAGE(Finish)
TESSERA_MESSAGE(Release, x.weight)
TESSERA_MESSAGE(Suspend)
TESSERA_MESSAGE(Abort, x.term)
TESSERA_MESSAGE(ShareOpened, x.node, x.failure, x.share, x.settled, x.threads, x.memory_bytes, x.name)
TESSERA_MESSAGE(ShareBegun, x.node)
TESSERA_MESSAGE(ShareIdle, x.node)
TESSERA_MESSAGE(ShareTally, x.node, x.epoch, x.wave, x.idle, x.sent, x.processed)
TESSERA_MESSAGE(ShareSettled, x.node, x.epoch)
TESSERA_MESSAGE(ShareCollected, x.node, x.epoch)
TESSERA_MESSAGE(ShareReleased, x.node, x.tiles)
TESSERA_MESSAGE(ShareProgress, x.node, x.tiles_begun, x.weight_begun, x.tiles_stored, x.tiles_asleep, x.updates_sent,
                x.updates_processed, x.items_sent, x.memory_bytes, x.outboxes, x.spans, x.mail)
TESSERA_MESSAGE(TileDone, x.stage, x.tile, x.microseconds)
TESSERA_MESSAGE(ShareEnded, x.node, x.failure, x.of_node, x.items, x.updates, x.hops, x.sleeps, x.most_received,
                x.begin_us, x.exchange_us, x.collect_us, x.outboxes, x.handed, x.not_handed)
TESSERA_MESSAGE(HandOver)
TESSERA_MESSAGE(RouteSplit, x.run_folder, x.split, x.attempt, x.shares, x.router)
TESSERA_MESSAGE(SplitRouted, x.attempt, x.routed, x.done, x.failure)

// A receipt is the tile, the length and then raw bytes.
inline caf::error inspect(caf::serializer& f, TileReceipt& x) {
  std::uint64_t n = x.receipt.size();
  if (auto failed = f(x.tile, n)) return failed;
  return n > 0 ? f.apply_raw(n, x.receipt.data()) : caf::error{};
}
inline caf::error inspect(caf::deserializer& f, TileReceipt& x) {
  std::uint64_t n = 0;
  if (auto failed = f(x.tile, n)) return failed;
  if (n > receipt_bytes_max) return caf::sec::invalid_argument;  // before memory is taken
  x.receipt.resize(n);
  return n > 0 ? f.apply_raw(n, x.receipt.data()) : caf::error{};
}

// An update is numbers, and then the message as one block of raw bytes.
inline caf::error inspect(caf::serializer& f, Update& x) {
  std::uint64_t n = x.message.size();
  if (auto failed = f(x.from.tile, x.from.incarnation, x.to.tile, x.to.incarnation, x.epoch, x.hops, n)) return failed;
  return n > 0 ? f.apply_raw(n, x.message.data()) : caf::error{};
}
inline caf::error inspect(caf::deserializer& f, Update& x) {
  std::uint64_t n = 0;
  if (auto failed = f(x.from.tile, x.from.incarnation, x.to.tile, x.to.incarnation, x.epoch, x.hops, n)) return failed;
  if (n > message_bytes_max) return caf::sec::invalid_argument;  // before memory is taken
  x.message.resize(n);
  return n > 0 ? f.apply_raw(n, x.message.data()) : caf::error{};
}

inline caf::error inspect(caf::serializer& f, Packet& x) {
  std::uint64_t n = x.updates.size();
  if (auto failed = f(x.from, x.window_bytes, n)) return failed;
  for (Update& update : x.updates) {
    if (auto failed = f(update)) return failed;
  }
  return caf::error{};
}
inline caf::error inspect(caf::deserializer& f, Packet& x) {
  std::uint64_t n = 0;
  if (auto failed = f(x.from, x.window_bytes, n)) return failed;
  x.updates.clear();
  // Grows with the updates that are there, whatever number was announced, so a forged number takes no memory.
  for (; n > 0; --n) {
    if (auto failed = f(x.updates.emplace_back())) return failed;
  }
  return caf::error{};
}

}  // namespace tessera

TESSERA_STAYS_HERE(tessera::Cancel)
TESSERA_STAYS_HERE(tessera::Delivery)
TESSERA_STAYS_HERE(tessera::GraceOver)
TESSERA_STAYS_HERE(tessera::Permit)
TESSERA_STAYS_HERE(tessera::Leave)
TESSERA_STAYS_HERE(tessera::MailNotice)
TESSERA_STAYS_HERE(tessera::NobodyCame)
TESSERA_STAYS_HERE(tessera::NodeBack)
TESSERA_STAYS_HERE(tessera::NodeJoined)
TESSERA_STAYS_HERE(tessera::NodeLeaves)
TESSERA_STAYS_HERE(tessera::NodeLet)
TESSERA_STAYS_HERE(tessera::NodeLost)
TESSERA_STAYS_HERE(tessera::Outgoing)
TESSERA_STAYS_HERE(tessera::Rejoin)
TESSERA_STAYS_HERE(tessera::Taken)
TESSERA_STAYS_HERE(tessera::TileFailed)
TESSERA_STAYS_HERE(tessera::TileLeft)
TESSERA_STAYS_HERE(tessera::TileRejoined)
TESSERA_STAYS_HERE(tessera::TileReport)
TESSERA_STAYS_HERE(tessera::TileStored)

CAF_BEGIN_TYPE_ID_BLOCK(tessera, first_custom_type_id)
CAF_ADD_TYPE_ID(tessera, (tessera::Abort))
CAF_ADD_TYPE_ID(tessera, (tessera::BeginShare))
CAF_ADD_TYPE_ID(tessera, (tessera::ChangeTable))
CAF_ADD_TYPE_ID(tessera, (tessera::Collect))
CAF_ADD_TYPE_ID(tessera, (tessera::Credit))
CAF_ADD_TYPE_ID(tessera, (tessera::Finish))
CAF_ADD_TYPE_ID(tessera, (tessera::FindShare))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareFound))
CAF_ADD_TYPE_ID(tessera, (tessera::HandOver))
CAF_ADD_TYPE_ID(tessera, (tessera::OpenShare))
CAF_ADD_TYPE_ID(tessera, (tessera::Packet))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareBegun))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareCollected))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareEnded))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareIdle))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareOpened))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareProgress))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareReleased))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareSettled))
CAF_ADD_TYPE_ID(tessera, (tessera::ShareTally))
CAF_ADD_TYPE_ID(tessera, (tessera::Probe))
CAF_ADD_TYPE_ID(tessera, (tessera::Release))
CAF_ADD_TYPE_ID(tessera, (tessera::RouteSplit))
CAF_ADD_TYPE_ID(tessera, (tessera::Settle))
CAF_ADD_TYPE_ID(tessera, (tessera::SplitRouted))
CAF_ADD_TYPE_ID(tessera, (tessera::Suspend))
CAF_ADD_TYPE_ID(tessera, (tessera::TileDone))
CAF_END_TYPE_ID_BLOCK(tessera)

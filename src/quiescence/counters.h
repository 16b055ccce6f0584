// What a tile has sent and processed, per peer incarnation: a tile that is rebuilt after a crash is another peer, and
// what was exchanged with the dead one no longer counts (docs/design.md, section 3).
#pragma once

#include <compare>
#include <cstdint>
#include <map>

#include "src/base/ids.h"

namespace tessera {

struct Peer {
  TileId tile;
  std::uint32_t incarnation = 0;
  friend constexpr auto operator<=>(const Peer&, const Peer&) = default;
};

struct Totals {
  std::uint64_t sent = 0, processed = 0;
  friend bool operator==(const Totals&, const Totals&) = default;
  Totals& operator+=(const Totals& other) {
    sent += other.sent;
    processed += other.processed;
    return *this;
  }
};

class PeerCounters {
 public:
  void add_sent(Peer peer) { ++count_[peer].sent; }
  void add_processed(Peer peer) { ++count_[peer].processed; }
  // The dead incarnation's messages vanish from both sides of the sum.
  void forget(Peer peer) { count_.erase(peer); }
  Totals totals() const;

 private:
  std::map<Peer, Totals> count_;
};

}  // namespace tessera

// Counts the updates that a tile has sent to and processed from each incarnation of each other tile. A tile that begins
// again after a loss is another peer, and what was exchanged with the dead incarnation no longer counts
// (docs/design.md, section 3).
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/base/ids.h"
#include "src/exchange/epoch.h"

namespace tessera {

struct TileIncarnation {
  TileId tile;
  Incarnation incarnation;
  friend constexpr auto operator<=>(const TileIncarnation&, const TileIncarnation&) = default;
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

// The counters of one tile. The array is sorted and flat to save memory: a tile in space has some sixty peers, and
// there are many tiles.
class PeerCounters {
 public:
  void add_sent(TileIncarnation peer) { ++at(peer).sent; }
  void add_processed(TileIncarnation peer) { ++at(peer).processed; }
  // Removes the counters of all peers for which `dead(TileIncarnation)` is true. When both sides do so, what was
  // exchanged with a dead incarnation vanishes from the sums of sent and of processed updates.
  template <class Dead>
  void forget_if(const Dead& dead) {
    std::erase_if(count_, [&](const Count& c) { return dead(TileIncarnation{c.tile, lives_[c.life]}); });
  }
  // Gives back the memory that was reserved for further peers.
  void trim() {
    count_.shrink_to_fit();
    lives_.shrink_to_fit();
  }
  Totals totals() const;
  std::size_t memory() const { return count_.capacity() * sizeof(Count) + lives_.capacity() * sizeof(Incarnation); }

 private:
  struct Count {
    TileId tile;
    std::uint32_t life = 0;                 // index of the incarnation in lives_
    std::uint32_t sent = 0, processed = 0;  // 32 bits are enough, because updates tell something new
  };
  std::uint32_t life_of(Incarnation incarnation);
  Count& at(TileIncarnation peer);

  std::vector<Count> count_;        // sorted by tile and life
  std::vector<Incarnation> lives_;  // all incarnations of peers: hardly ever more than one
};

}  // namespace tessera

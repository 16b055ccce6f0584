// What a tile has sent and processed, per peer incarnation: a tile that is rebuilt after a crash is another peer, and
// what was exchanged with the dead one no longer counts (docs/design.md, section 3).
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

// Sorted and flat: a tile in space has some sixty peers, and there are many tiles.
class PeerCounters {
 public:
  void add_sent(TileIncarnation peer) { ++at(peer).sent; }
  void add_processed(TileIncarnation peer) { ++at(peer).processed; }
  // What was exchanged with dead incarnations vanishes from both sides of the sum.
  template <class Dead>
  void forget_if(const Dead& dead) {
    std::erase_if(count_, [&](const Count& c) { return dead(TileIncarnation{c.tile, lives_[c.life]}); });
  }
  // Gives back what was taken for peers to come.
  void trim() {
    count_.shrink_to_fit();
    lives_.shrink_to_fit();
  }
  Totals totals() const;
  std::size_t memory() const { return count_.capacity() * sizeof(Count) + lives_.capacity() * sizeof(Incarnation); }

 private:
  struct Count {
    TileId tile;
    std::uint32_t life = 0;                 // of the tile: which of lives_
    std::uint32_t sent = 0, processed = 0;  // an update tells of something new: there are fewer than vertices
  };
  std::uint32_t life_of(Incarnation incarnation);
  Count& at(TileIncarnation peer);

  std::vector<Count> count_;        // by tile and life
  std::vector<Incarnation> lives_;  // of peers: hardly ever more than one
};

}  // namespace tessera

#include "src/exchange/counters.h"

#include <algorithm>
#include <utility>

namespace tessera {

std::uint32_t PeerCounters::life_of(Incarnation incarnation) {
  auto found = std::find(lives_.begin(), lives_.end(), incarnation);
  if (found == lives_.end()) found = lives_.insert(lives_.end(), incarnation);
  return static_cast<std::uint32_t>(found - lives_.begin());
}

PeerCounters::Count& PeerCounters::at(TileIncarnation peer) {
  const std::pair wanted(peer.tile, life_of(peer.incarnation));
  const auto key = [](const Count& c) { return std::pair(c.tile, c.life); };
  auto found = std::lower_bound(count_.begin(), count_.end(), wanted,
                                [&](const Count& c, const auto& value) { return key(c) < value; });
  if (found != count_.end() && key(*found) == wanted) return *found;
  // Grows by less than the usual factor, because these arrays stay in memory while their tiles are asleep.
  if (count_.size() == count_.capacity()) {
    const auto index = found - count_.begin();
    count_.reserve(count_.size() + count_.size() / 8 + 4);
    found = count_.begin() + index;
  }
  return *count_.insert(found, {wanted.first, wanted.second, 0, 0});
}

Totals PeerCounters::totals() const {
  Totals sum;
  for (const Count& c : count_) sum += {c.sent, c.processed};
  return sum;
}

}  // namespace tessera

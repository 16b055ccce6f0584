#include "src/exchange/counters.h"

#include <algorithm>

namespace tessera {

std::vector<PeerCounters::Count>::iterator PeerCounters::place(Peer peer) {
  return std::lower_bound(count_.begin(), count_.end(), peer, [](const Count& c, Peer p) { return c.peer < p; });
}

PeerCounters::Count& PeerCounters::at(Peer peer) {
  auto found = place(peer);
  if (found != count_.end() && found->peer == peer) return *found;
  if (count_.size() == count_.capacity()) {  // by less than the half that is usual: these stay while tiles are asleep
    const auto index = found - count_.begin();
    count_.reserve(count_.size() + count_.size() / 8 + 4);
    found = count_.begin() + index;
  }
  return *count_.insert(found, {peer, 0, 0});
}

Totals PeerCounters::totals() const {
  Totals sum;
  for (const Count& c : count_) sum += {c.sent, c.processed};
  return sum;
}

}  // namespace tessera

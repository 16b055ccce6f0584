#include "src/quiescence/counters.h"

namespace tessera {

Totals PeerCounters::totals() const {
  Totals sum;
  for (const auto& [peer, count] : count_) sum += count;
  return sum;
}

}  // namespace tessera

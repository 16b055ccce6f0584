// Counts the updates by itself, to check what the tiles count and when quiescence is believed.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <map>
#include <utility>

#include "actors/harness/memory_faults.h"
#include "src/exchange/routing_table.h"
#include "src/exchange/tile_life.h"

namespace tessera {

class Truth final : public ExchangeWatch {
 public:
  explicit Truth(MemoryFaults* memory_faults) : memory_faults_(memory_faults) {}

  void sent(TileIncarnation from, TileIncarnation to, Totals now) override {
    const Turn ours(memory_faults_, false);
    ++sent_;
    ++under_way_;
    ++by_pair_[{from, to}];
    note(from, now);
  }
  void processed(TileIncarnation from, TileIncarnation to, Totals now) override {
    const Turn ours(memory_faults_, false);
    --under_way_;
    --by_pair_[{from, to}];
    note(to, now);
  }
  void rejoined(TileIncarnation self, Totals now) override {
    const Turn ours(memory_faults_, false);
    forgotten_ |= totals_[self] != now;
    note(self, now);
  }

  // Returns how many updates were sent and not processed between tiles that live by this table.
  std::int64_t under_way(const RoutingTable& table) const {
    std::int64_t sum = 0;
    for (const auto& [pair, updates] : by_pair_) {
      if (table.alive(pair.first) && table.alive(pair.second)) sum += std::abs(updates);
    }
    return sum;
  }
  std::uint64_t sent() const { return sent_; }
  // Returns whether the counters of all tiles differ by the number of updates under way. Always true once a tile has
  // forgotten what it exchanged with a dead one, as after a loss; a node that cannot open its share counts as lost,
  // too.
  bool agrees() const { return forgotten_ || counted_ == under_way_; }

 private:
  void note(TileIncarnation self, Totals now) {
    Totals& before = totals_[self];
    counted_ +=
        static_cast<std::int64_t>(now.sent - before.sent) - static_cast<std::int64_t>(now.processed - before.processed);
    before = now;
  }

  MemoryFaults* memory_faults_;
  std::map<TileIncarnation, Totals> totals_;
  std::map<std::pair<TileIncarnation, TileIncarnation>, std::int64_t> by_pair_;
  bool forgotten_ = false;
  std::int64_t under_way_ = 0, counted_ = 0;
  std::uint64_t sent_ = 0;
};

}  // namespace tessera

// Counts how many bytes the tiles of a node send to others, for display. There is a counter for each pair of regions of
// the map of tiles, so the size does not depend on the number of tiles. Thread-safe. The result of a job does not
// depend on these counts.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/base/mail_arcs.h"

namespace tessera {

class MailCounts {
 public:
  static constexpr std::size_t regions_max = 128;  // regions of the map: 128 KiB of counters

  explicit MailCounts(MapRegions regions)
      : regions_(std::move(regions)), bytes_(regions_.codes.size() * regions_.codes.size()) {}

  void add(TileId from, TileId to, std::size_t bytes) noexcept {
    if (from.value >= regions_.of_tile.size() || to.value >= regions_.of_tile.size()) return;
    const std::size_t a = regions_.of_tile[from.value], b = regions_.of_tile[to.value];
    if (a == b || a == MapRegions::nowhere || b == MapRegions::nowhere) return;
    bytes_[a * regions_.codes.size() + b].fetch_add(bytes, std::memory_order_relaxed);
  }

  // Returns the `max` pairs of regions with the most bytes since the last call. The counts of all other pairs are
  // forgotten.
  std::vector<MailArc> take(std::size_t max) {
    std::vector<MailArc> arcs;
    const std::size_t regions = regions_.codes.size();
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      if (bytes_[i].load(std::memory_order_relaxed) == 0) continue;
      arcs.push_back(
          {regions_.codes[i / regions], regions_.codes[i % regions], bytes_[i].exchange(0, std::memory_order_relaxed)});
    }
    return heaviest(std::move(arcs), max);
  }

 private:
  MapRegions regions_;
  std::vector<std::atomic<std::uint64_t>> bytes_;  // row by row: from, to
};

}  // namespace tessera

// How many bytes the tiles of a node tell others, for those who watch: a counter for each two parts of the map of
// tiles, whatever the number of tiles. Safe from any thread; nothing that the result depends on.
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
  static constexpr std::size_t parts_max = 128;  // 128 KiB of counters

  explicit MailCounts(MapParts parts) : parts_(std::move(parts)), bytes_(parts_.codes.size() * parts_.codes.size()) {}

  void add(TileId from, TileId to, std::size_t bytes) noexcept {
    if (from.value >= parts_.of_tile.size() || to.value >= parts_.of_tile.size()) return;
    const std::size_t a = parts_.of_tile[from.value], b = parts_.of_tile[to.value];
    if (a == b || a == MapParts::nowhere || b == MapParts::nowhere) return;
    bytes_[a * parts_.codes.size() + b].fetch_add(bytes, std::memory_order_relaxed);
  }

  // The heaviest since it was asked last; the others are forgotten.
  std::vector<MailArc> take(std::size_t max) {
    std::vector<MailArc> arcs;
    const std::size_t parts = parts_.codes.size();
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      if (bytes_[i].load(std::memory_order_relaxed) == 0) continue;
      arcs.push_back(
          {parts_.codes[i / parts], parts_.codes[i % parts], bytes_[i].exchange(0, std::memory_order_relaxed)});
    }
    return heaviest(std::move(arcs), max);
  }

 private:
  MapParts parts_;
  std::vector<std::atomic<std::uint64_t>> bytes_;  // row by row: from, to
};

}  // namespace tessera

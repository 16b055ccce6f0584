// What a node is doing and has done for all its jobs. Its shares write it, and any thread may read it.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>

#include "src/exchange/outbox.h"

namespace tessera {

struct NodeWork {
  std::uint64_t shares = 0, tiles_asleep = 0, tile_memory_bytes = 0, waiting_bytes = 0;  // at present
  std::uint64_t tiles_begun = 0, weight_begun = 0, tiles_stored = 0;  // since the start, as are `outboxes`
  OutboxCounts outboxes;
};

class NodeMeter {
 public:
  // Replaces what was told of one share. `share` is a number of the share's own.
  void tell(std::uint64_t share, const NodeWork& work) {
    const std::lock_guard lock(mutex_);
    shares_[share] = work;
  }
  // The share has ended: nothing is under way there any more.
  void end(std::uint64_t share) noexcept {
    const std::lock_guard lock(mutex_);
    const auto found = shares_.find(share);
    if (found == shares_.end()) return;
    add_ever(ended_, found->second);
    shares_.erase(found);
  }
  NodeWork now() const {
    const std::lock_guard lock(mutex_);
    NodeWork sum = ended_;
    for (const auto& [share, work] : shares_) {
      ++sum.shares;
      sum.tiles_asleep += work.tiles_asleep;
      sum.tile_memory_bytes += work.tile_memory_bytes;
      sum.waiting_bytes += work.waiting_bytes;
      add_ever(sum, work);
    }
    return sum;
  }

 private:
  static void add_ever(NodeWork& sum, const NodeWork& work) {
    sum.tiles_begun += work.tiles_begun;
    sum.weight_begun += work.weight_begun;
    sum.tiles_stored += work.tiles_stored;
    sum.outboxes += work.outboxes;
  }

  mutable std::mutex mutex_;
  std::map<std::uint64_t, NodeWork> shares_;
  NodeWork ended_;
};

}  // namespace tessera

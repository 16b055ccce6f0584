// What a node is doing and has done for all its jobs. Its shares write it, and any thread may read it.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>

#include "src/exchange/outbox.h"

namespace tessera {

struct NodeWork {
  std::uint64_t parts = 0, tiles_asleep = 0, tile_memory_bytes = 0, waiting_bytes = 0;  // at present
  std::uint64_t tiles_begun = 0, weight_begun = 0, tiles_stored = 0;  // since the start, as are `outboxes`
  OutboxCounts outboxes;
};

class NodeMeter {
 public:
  // Replaces what was told of one share. `part` is a number of the share's own.
  void tell(std::uint64_t part, const NodeWork& work) {
    const std::lock_guard lock(mutex_);
    parts_[part] = work;
  }
  // The share has ended: nothing is under way there any more.
  void end(std::uint64_t part) noexcept {
    const std::lock_guard lock(mutex_);
    const auto found = parts_.find(part);
    if (found == parts_.end()) return;
    add_ever(ended_, found->second);
    parts_.erase(found);
  }
  NodeWork now() const {
    const std::lock_guard lock(mutex_);
    NodeWork sum = ended_;
    for (const auto& [part, work] : parts_) {
      ++sum.parts;
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
  std::map<std::uint64_t, NodeWork> parts_;
  NodeWork ended_;
};

}  // namespace tessera

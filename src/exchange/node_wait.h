// The waits of a job for another node: when no node is left, or when none that is there has the memory for a tile. It
// says when such a wait is over in vain. A plain object without clock: it is told when time is up.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "src/base/result.h"

namespace tessera {

class NodeWait {
 public:
  // Begins a wait, and returns its number, which tells it from earlier ones. `missed` is why the job fails when no node
  // comes.
  std::uint64_t begin(Error missed) {
    missed_ = std::move(missed);
    return ++waits_;
  }
  // A node was lost before any share was opened. The nodes that are left may be unable to open their shares, and the
  // job then waits for others.
  void note_loss() { ++waits_; }
  // Returns whether the job has waited for a node, or has lost one early.
  bool has_waited() const { return waits_ > 0; }

  // No node has the memory for one of the tiles. Returns false when this is known already.
  bool begin_without_room() { return !std::exchange(without_room_, true); }
  void has_room() { without_room_ = false; }
  bool without_room() const { return without_room_; }

  // The time of a wait is up. Returns why the job fails, or nothing: another wait has begun since, or there is a node.
  // `nobody` says whether no node is there.
  std::optional<Error> time_is_up(std::uint64_t wait, bool nobody) {
    if (wait != waits_ || !(nobody || without_room_)) return std::nullopt;
    return std::move(missed_);
  }

 private:
  Error missed_{Errc::ok, {}};
  std::uint64_t waits_ = 0;
  bool without_room_ = false;
};

}  // namespace tessera

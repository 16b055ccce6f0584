// Numbers that tell what still counts: of coordinators, of routing tables, of lives of tiles, and of waves.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "src/base/ids.h"

namespace tessera {

// The number of a coordinator of a job. The coordinators of one job have increasing terms, and the highest is obeyed.
using Term = Id<struct TermTag, std::uint32_t>;
// The number of one collection of counters by a coordinator.
using Wave = Id<struct WaveTag, std::uint64_t>;

// The number of a routing table. Epochs are compared by term first, so every epoch of a later term is greater than all
// epochs that a replaced coordinator can still make.
struct Epoch {
  Term term;
  std::uint32_t number = 0;
  friend constexpr auto operator<=>(const Epoch&, const Epoch&) = default;
  // Returns the epoch that follows this one when the coordinator has the term `of`.
  Epoch next(Term of) const { return term < of ? Epoch{of, 0} : Epoch{term, number + 1}; }
  friend std::string to_string(const Epoch& epoch) {
    return to_string(epoch.term) + "." + std::to_string(epoch.number);
  }
};

// The number of one life of a tile. Incarnations are compared by term first, as epochs are.
struct Incarnation {
  Term term;
  std::uint32_t number = 0;
  friend constexpr auto operator<=>(const Incarnation&, const Incarnation&) = default;
  Incarnation next(Term of) const { return term < of ? Incarnation{of, 0} : Incarnation{term, number + 1}; }
};

}  // namespace tessera

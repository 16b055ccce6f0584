// Numbers that tell what still counts: of coordinators, tables, lives of tiles, and questions whether all is quiet.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "src/base/ids.h"

namespace tessera {

// Of the coordinators of one job, one after the other: the one with the highest is obeyed.
using Term = Id<struct TermTag, std::uint32_t>;
// Of the collections of counters by one coordinator.
using Wave = Id<struct WaveTag, std::uint64_t>;

// Of a table. Those of a later term are greater, whatever tables a coordinator that was replaced still makes.
struct Epoch {
  Term term;
  std::uint32_t number = 0;
  friend constexpr auto operator<=>(const Epoch&, const Epoch&) = default;
  // The one that a coordinator of this term makes after it.
  Epoch next(Term of) const { return term < of ? Epoch{of, 0} : Epoch{term, number + 1}; }
  friend std::string to_string(const Epoch& epoch) {
    return to_string(epoch.term) + "." + std::to_string(epoch.number);
  }
};

// A life of a tile, likewise.
struct Incarnation {
  Term term;
  std::uint32_t number = 0;
  friend constexpr auto operator<=>(const Incarnation&, const Incarnation&) = default;
  Incarnation next(Term of) const { return term < of ? Incarnation{of, 0} : Incarnation{term, number + 1}; }
};

}  // namespace tessera

// Stored results of a few points that are changed again and again, without threads, files or actors: one seeded,
// arbitrary order of everything that can happen. After each change every tile is compared with CGAL's triangulation.
#pragma once

#include <cstdint>
#include <string>

namespace tessera::testing {

// A part of the rule that is left out: of what a tile begins from, or of what tiles do.
enum class Mutant : std::uint8_t {
  none,
  no_common,              // nobody is told of a common point
  common_for_the_lonely,  // only tiles that know no foreign point are told of it
  new_common,             // it may be a new point
  least_common,           // it is the least point, old or new, and is told to tiles that know none that is less
  affected_not_fresh,     // the neighbours of removed points are not fresh
  begin_if_changed,       // a tile whose points are only affected does not begin
  no_foreign,             // stored foreign vertices are forgotten by tiles that begin
  removed_foreign,        // removed foreign vertices are kept
  foreign_pairs,          // and the following: LeftOut
  old_arrivals,
  refused_fresh,
  answers,
  missed_removals,  // a live tile is not told of what was removed while it slept
  forgotten_sent,   // a live tile keeps what it had told in the change before, and the following: LeftOut
  forgotten_fresh,
  forgotten_refused,
  untold_holes,  // a tile is not told the points around a hole that is filled
  shared_holes,  // a hole is filled although several tiles own its removed points
  no_replay,     // nothing is repeated for tiles that were lost
  replayed_quotes,
};

struct ChangeOptions {
  std::uint64_t seed = 0;    // of the first world
  std::uint64_t worlds = 1;  // each a first triangulation and five changes
  Mutant mutant = Mutant::none;
  bool losses = false;  // tiles are lost and begin again
  bool live = false;    // tiles stay in memory from change to change, and are changed in place
};

struct ChangeReport {
  std::uint64_t removals = 0, additions = 0, both = 0;  // changes
  std::uint64_t skipped = 0;                            // changes that leave no points that span space
  std::uint64_t tiles = 0, begun = 0, woken = 0, sent = 0, lost = 0;
  std::uint64_t changes() const { return removals + additions + both; }
  std::string wrong;  // the first wrong answer, or ""
};

// Runs worlds until a result is wrong.
ChangeReport change_worlds(const ChangeOptions& options);

}  // namespace tessera::testing

// The table of the phases of a job: names, words, order, shares of the time, and other properties. A new phase is a new
// row. Code asks for a property of a row, never for a certain phase that happens to have the property.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "src/base/tile_map.h"

namespace tessera {

enum class Phase : std::uint8_t { planning, routing, triangulating, splaying, collecting, finishing, done };

// What tiles compute (src/exchange/tile_program.h). A program has three steps: each tile begins, tiles exchange
// messages until no message is left, and each tile stores what it has.
enum class ProgramKind : std::uint8_t { none, delaunay };
enum class StageStep : std::uint8_t { none, begin, exchange, store };

// A member of Progress. Counters of tiles exist for each node, too.
enum class ProgressCounter : std::uint8_t {
  none,
  points_routed,
  points_triangulated,
  points_sent,
  tiles_triangulated,
  tiles_stored
};

struct PhaseRow {
  Phase phase;
  const char* name;   // in messages, manifests, metrics and JSON; must never change
  const char* label;  // what the phase does, for people who have not read how

  ProgramKind program = ProgramKind::none;
  StageStep step = StageStep::none;
  bool exchanges = false;  // tiles send messages to each other
  bool settled = false;    // no tile has anything more to tell another tile
  bool over = false;       // nothing is left to do

  double share = 0;  // the share of a job's time; the progress shown is computed from it
  // The fraction of the phase that is done is the greater of these counters relative to their totals. Without a counter
  // the end cannot be foreseen, and the phase counts when it is over.
  std::array<ProgressCounter, 2> counters = {};
  ProgressCounter points = ProgressCounter::none;  // its growth is shown as points a second
  // counts the tiles that have come as far as the phase goes
  ProgressCounter tiles = ProgressCounter::tiles_triangulated;
  std::optional<TileStatus> reached = {};  // the state of a tile that was worked on

  // The colours in the report, on light and dark paper. Null: the report does not show the phase.
  const char* colour = nullptr;
  const char* dark_colour = nullptr;
};

// The shares were measured with 10 M uniform points on two threads, and rounded.
inline constexpr auto phase_table = std::to_array<PhaseRow>({
    {
        .phase = Phase::planning,
        .name = "planning",
        .label = "planning",
        .points = ProgressCounter::points_routed,
    },
    {
        .phase = Phase::routing,
        .name = "routing",
        .label = "reading",
        .share = 0.08,
        .counters = {ProgressCounter::points_routed},
        .points = ProgressCounter::points_routed,
        .colour = "#8a94a6",
        .dark_colour = "#7d8798",
    },
    {
        .phase = Phase::triangulating,
        .name = "triangulating",
        .label = "triangulating",
        .program = ProgramKind::delaunay,
        .step = StageStep::begin,
        .exchanges = true,  // a tile that has begun tells its neighbours
        .share = 0.55,
        .counters = {ProgressCounter::points_triangulated, ProgressCounter::tiles_triangulated},
        .points = ProgressCounter::points_triangulated,
        .reached = TileStatus::triangulated,
        .colour = "#2f6db5",
        .dark_colour = "#5b9be0",
    },
    {
        .phase = Phase::splaying,
        .name = "splaying",
        .label = "joining tiles",
        .program = ProgramKind::delaunay,
        .step = StageStep::exchange,
        .exchanges = true,
        .share = 0.12,
        .points = ProgressCounter::points_sent,
        .reached = TileStatus::splayed,
        .colour = "#e08a2c",
        .dark_colour = "#f0a04b",
    },
    {
        .phase = Phase::collecting,
        .name = "collecting",
        .label = "writing",
        .program = ProgramKind::delaunay,
        .step = StageStep::store,
        .settled = true,
        .share = 0.25,
        .counters = {ProgressCounter::tiles_stored},
        .tiles = ProgressCounter::tiles_stored,
        .colour = "#3d9a6a",
        .dark_colour = "#58bd88",
    },
    {
        .phase = Phase::finishing,
        .name = "finishing",
        .label = "finishing",
        .settled = true,
        .tiles = ProgressCounter::tiles_stored,
        .colour = "#8a63b0",
        .dark_colour = "#ab88d0",
    },
    {
        .phase = Phase::done,
        .name = "done",
        .label = "done",
        .settled = true,
        .over = true,
        .tiles = ProgressCounter::tiles_stored,
    },
});

constexpr const PhaseRow& row_of(Phase phase) { return phase_table[static_cast<std::size_t>(phase)]; }
constexpr const char* name_of(Phase phase) { return row_of(phase).name; }

static_assert([] {
  std::size_t place = 0;
  for (const PhaseRow& row : phase_table) {
    if (row.phase != static_cast<Phase>(place++)) return false;
  }
  return phase_table.back().over;
}());

// The first phase for whose row `is` returns true.
template <class Is>
constexpr std::optional<Phase> phase_where(Is is) {
  for (const PhaseRow& row : phase_table) {
    if (is(row)) return row.phase;
  }
  return std::nullopt;
}

// The phase whose name_of() is `name`. Nothing for a name that only another release knows.
constexpr std::optional<Phase> phase_named(std::string_view name) {
  return phase_where([name](const PhaseRow& row) { return row.name == name; });
}

// The phase in which tiles do this step of the program. REQUIRES: the program has the step.
constexpr Phase phase_of(ProgramKind program, StageStep step) {
  return phase_where([=](const PhaseRow& row) { return row.program == program && row.step == step; }).value();
}

}  // namespace tessera

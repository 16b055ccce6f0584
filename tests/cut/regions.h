// A graph over several regions, and a network between them that reorders, repeats and loses: what the exchange of tiles
// does for regions, and all that it may do to them. Mutants leave out one thing of it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "src/cut/cut_graph.h"
#include "src/cut/discharge.h"
#include "src/cut/flood.h"
#include "tests/cut/whole_graph.h"

namespace tessera::cut {

struct Place {
  std::uint32_t region = 0, number = 0;  // a cell of the region, or a border
};

struct Split {
  std::vector<CutGraph> graphs;                   // by region
  std::vector<std::vector<std::uint32_t>> cells;  // by region and cell: of the whole
  std::vector<std::vector<Place>> across;         // by region and border: the same border, as the other region has it
};
Split split(const WholeGraph& whole, const std::vector<std::uint32_t>& region_of, std::uint32_t regions);

// Cells that a region decides alone, and what its neighbours make of that, until nobody decides more: `source` are
// those decided for the source, `split` becomes the kernels.
void reduce(Split& split, std::vector<bool>& source);

enum class Mutant : std::uint8_t { none, no_flood, labels_are_the_answer, last_heard, old_mail, fixed_bound };

struct NetworkOptions {
  std::uint32_t bound = 8;
  std::uint32_t crashes = 0;
  Mutant mutant = Mutant::none;
};

struct CutFound {
  std::vector<bool> source;  // by cell of the whole
  std::uint32_t floods = 0, discharges = 0;
};
// Nothing when there is no end.
std::optional<CutFound> run_regions(const Split& split, std::uint32_t cells, const NetworkOptions& options,
                                    std::mt19937_64& random);

}  // namespace tessera::cut

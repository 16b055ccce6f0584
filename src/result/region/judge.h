// Which cells of a triangulation of some units are final in a region, and what has to be read for the others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/result/region/growing.h"
#include "src/result/region/region_shape.h"
#include "src/result/region/unit_tree.h"

namespace tessera {

enum class CellState : std::uint8_t {
  elsewhere,  // the region does not depend on it
  open,       // an unread unit may hold a point that changes it
  final,      // a cell of the triangulation of the whole cloud
};

struct Judgement {
  std::vector<CellState> states;    // by cell, infinite ones included
  std::uint64_t met = 0, open = 0;  // finite cells that meet the region; of those, not final
  std::uint64_t hull_open = 0;      // infinite cells on which the region depends that are not final
  std::vector<std::size_t> units;   // for each cell that is not final the nearest that it meets; ascending, each once

  bool complete() const { return open == 0 && hull_open == 0; }
};

// What the region depends on are the finite cells that meet it, and the infinite ones beyond whose facet some of it is,
// or whose facet it touches. When all of them are final, the finite ones are the cells of the whole triangulation that
// meet the region (docs/regions.md). REQUIRES: triangulation.rank() == dimension(); `cells` are its cells.
// `shape`: the part of the box that is the region; the facets of the hull are those of the box. Throws
// Stopped.
Judgement judge(const GrowingTriangulation& triangulation, const CellList& cells, const Bounds& region,
                const RegionShape& shape, const UnitTree& unread, const std::stop_token& stop);

}  // namespace tessera

// Decides which cells of a triangulation of some units are final in a region, and which units must be read for the
// other cells.
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
  elsewhere,  // the region does not depend on the cell
  open,       // an unread unit may hold a point that changes the cell
  final,      // a cell of the triangulation of the whole cloud
};

struct Judgement {
  std::vector<CellState> states;    // by cell, infinite cells included
  std::uint64_t met = 0, open = 0;  // finite cells that meet the region, and those of them that are not final
  std::uint64_t hull_open = 0;      // infinite cells on which the region depends and that are not final
  std::vector<std::size_t> units;   // for each open cell the nearest unread unit in its reach; ascending, each once

  bool complete() const { return open == 0 && hull_open == 0; }
};

// Judges the cells. The region depends on the finite cells that meet it, and on the infinite cells whose facet it
// touches or has a part beyond. When all these cells are final, the finite ones are the cells of the whole
// triangulation that meet the region (docs/regions.md). `cells` are the cells of `triangulation`. `region` is a box,
// and `shape` selects the part of the box that is the region; for the facets of the hull the whole box is used.
// `unread` has the units that were not read. REQUIRES: triangulation.rank() == dimension(). Throws Stopped.
Judgement judge(const GrowingTriangulation& triangulation, const CellList& cells, const Bounds& region,
                const RegionShape& shape, const UnitTree& unread, const std::stop_token& stop);

}  // namespace tessera

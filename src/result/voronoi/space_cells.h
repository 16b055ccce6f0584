// The Voronoi cells of the own points of a 3D tile, as records of a file of polyhedra.
#pragma once

#include <cstddef>
#include <optional>
#include <stop_token>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"
#include "src/result/voronoi/cell_counts.h"
#include "src/result/voronoi/cell_records.h"

namespace tessera::voronoi {

// Adds the cells of a tile, clipped to the box. Without a box cells are whole, and unbounded ones are left out. The
// shape of a record is a packed polyhedron. Errors: corrupt for a damaged tile; io; interrupted.
Result<CellCounts> add_space_cells(const TileSource& source, std::size_t index, const std::optional<Bounds>& box,
                                   CellRecords::Adder& to, const std::stop_token& stop);

}  // namespace tessera::voronoi

// The Voronoi cells of the own points of a 2D tile, as records of a map file.
#pragma once

#include <cstddef>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/tile_source.h"
#include "src/result/voronoi/cell_counts.h"
#include "src/result/voronoi/cell_records.h"
#include "src/result/voronoi/clip_region.h"
#include "src/result/voronoi/repairs.h"

namespace tessera::voronoi {

// Adds the cells of a tile. Without a region cells are whole, and unbounded ones have no shape. The shape of a record
// is a polygon as WKB, or with `multi` a multipolygon; without a shape it is an empty one. Where rounding
// has made a shape invalid, the record keeps it, and `repairs` gets what makes it valid. Errors: corrupt for a
// damaged tile; io; interrupted.
Result<CellCounts> add_planar_cells(const TileSource& source, std::size_t index, const ClipRegion* region, bool multi,
                                    Repairs& repairs, CellRecords::Adder& to, const std::stop_token& stop);

}  // namespace tessera::voronoi

// The cells of an area, of the hull, and one cell by its index.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "src/result/query/stored_triangulation.h"

namespace tessera::query {

// As the members of StoredTriangulation: cells(), hull(), cell() and tiles().
Result<CellSet> cells_of(const OpenedResult& result, const Area& area, const CellLimits& limits,
                         const AskOptions& options);
Result<HullCells> hull_of(const OpenedResult& result, const CellLimits& limits, const AskOptions& options,
                          std::optional<double> max_edge, std::optional<double> max_radius);
Result<Cell> cell_of(const OpenedResult& result, TileId id, std::int32_t place);
Result<std::vector<TileId>> tiles_of(const OpenedResult& result, const Area& area, const AskOptions& options);

}  // namespace tessera::query

// Chooses which of equal points in 2D is the vertex, where it is not the first, and counts duplicates at other heights.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/duplicate_policy.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

// Returns where a row has the height of its point; nothing in 3D, or when the schema has no height.
std::optional<std::size_t> height_offset(int dimension, const std::vector<Attribute>& schema);

// Returns the heights of points of a tile, in the order of the given ids. REQUIRES: the ids ascend.
using HeightsOf = std::function<Result<std::vector<double>>(std::span<const PointId>)>;

// order_points() keeps the first of equal points. This function puts the point that `keep` chooses in its place. It
// also sets tile.duplicates, and tile.other_heights: how many duplicates have another height than the kept point.
// `heights_of` may be null; then heights are unknown.
Status choose_kept(DuplicatePolicy keep, const HeightsOf& heights_of, LoadedTile& tile);

// The same for a tile that was loaded from a run; the heights come from the run's rows.
Status choose_kept(const RoutedCloud& run, TileId tile, LoadedTile& loaded);

// The same for the seeds, because every tile must know a seed by the source index of the vertex. Reads the records of
// tiles with seeds once, unless the first of equal points is kept.
Status choose_kept_seeds(RoutedCloud& run, const std::stop_token& stop);

}  // namespace tessera

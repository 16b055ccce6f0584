// Of equal points in 2D the one that the user wants, where it is not the first; and how many are at other heights.
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

// Where a row carries the height of its point; nothing in 3D, or when no file has any.
std::optional<std::size_t> height_offset(int dimension, const std::vector<Attribute>& schema);

// The heights of points of a tile, in the order of their ids here. Ascending ids.
using HeightsOf = std::function<Result<std::vector<double>>(std::span<const PointId>)>;

// Puts the kept point in the place of each that order_points() has kept, the first, and sets the duplicates and how
// many of them are at other heights than what is kept. Without `heights_of`, which may be null, no height is known.
Status choose_kept(DuplicatePolicy keep, const HeightsOf& heights_of, LoadedTile& tile);

// The same of what was loaded of a run.
Status choose_kept(const RoutedCloud& run, TileId tile, LoadedTile& loaded);

// The same of the seeds, which every tile must know by the source index of the vertex. Reads the tiles' records once,
// unless the first points are kept.
Status choose_kept_seeds(RoutedCloud& run, const std::stop_token& stop);

}  // namespace tessera

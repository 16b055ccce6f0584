// Finds the points of a result that are in a box, or of a class.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/tile_source.h"

namespace tessera {

struct PointSelection {
  std::optional<Box> box = {};    // closed
  std::vector<int> classes = {};  // values of the attribute "classification"
};

// Returns the vertices in the box, the vertices of these classes, and all duplicates of them, ascending. Results do not
// keep the attributes of duplicates, so a duplicate counts as of the class of its vertex. Errors: usage when the result
// has no classes; those of reading the result; interrupted.
Result<std::vector<PointId>> select_points(const TileSource& source, const PointSelection& selection, unsigned threads,
                                           const std::stop_token& stop);

}  // namespace tessera

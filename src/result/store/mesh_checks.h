// Checks the values of a tile that was read, in any format: every value that other code uses as an index.
#pragma once

#include <functional>
#include <string>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera::store {

// Makes the error of an array: "out/tiles/000042.vtu, PointData/id: reason". A place is "Points", "PointData/id",
// "Cells/connectivity", and so on.
using CorruptArray = std::function<Error(const std::string& place, const std::string& reason)>;

// Checks that points are finite, flags are 0 or 1, vertices and neighbours exist, and no cell has a vertex twice.
// REQUIRES: the lengths of the arrays agree.
Status check_values(const TileMesh& mesh, const CorruptArray& corrupt);

}  // namespace tessera::store

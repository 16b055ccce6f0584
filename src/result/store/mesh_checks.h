// What must hold for the arrays of a tile that was read, in whatever format: every value that others use as an index.
#pragma once

#include <functional>
#include <string>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera::store {

// Makes the error of an array: "out/tiles/000042.vtu, PointData/id: reason". Places are "Points", "PointData/id", ...,
// "Cells/connectivity".
using CorruptArray = std::function<Error(const std::string& place, const std::string& reason)>;

// Points are finite, flags are 0 or 1, vertices and neighbours exist, no cell has a vertex twice. REQUIRES: the arrays'
// lengths fit together.
Status check_values(const TileMesh& mesh, const CorruptArray& corrupt);

}  // namespace tessera::store

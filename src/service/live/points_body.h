// Reads new points and source indices as callers send them: JSON, a NumPy file, a message of proto/query.proto.
#pragma once

#include <string>
#include <vector>

#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/delaunay/update/update.h"
#include "src/result/store/tile_store.h"
#include "src/service/live/live_backend.h"

namespace tessera::service {

// The new points of a change, with rows in the schema of the result. Errors, which call the content the body: usage
// for attributes that differ from those of the result; bad_input for everything else that is no such points.
Result<ResultChange> read_points_body(const PointsBody& body, const Manifest& result);
// The points to be removed. Error bad_input.
Result<std::vector<PointId>> read_ids_body(const PointsBody& body);

}  // namespace tessera::service

// What callers are told of the tiles of a triangulation.
#pragma once

#include "service.pb.h"
#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera::service {

// The tiles of a triangulation that runs.
void tell_running(const Progress& progress, bool with_layout, proto::JobTiles& tiles);
// The tiles of a stored result. Error: that of Partition::from_json().
Status tell_stored(const Manifest& manifest, bool with_layout, proto::JobTiles& tiles);

}  // namespace tessera::service

// The steps that `triangulate` and `info` share: from options to a cloud and the size of its tiles.
#pragma once

#include <cstdint>
#include <stop_token>

#include "src/apps/triangulate_options.h"
#include "src/base/result.h"
#include "src/io/cloud.h"

namespace tessera {

// Opens the inputs; settles the dimension when it was left open (2 when no file holds z). What has to be unpacked waits
// in the result folder, or where it will stand; without one in the system's temporary folder.
Result<Cloud> open_cloud(TriangulateOptions& options, std::stop_token stop = {});

// Points a tile may hold, as asked for or chosen. Error memory when it cannot be worked on within the memory.
Result<std::uint64_t> tile_limit(const TriangulateOptions& options, const Cloud& cloud);

}  // namespace tessera

// tessera triangulate --server: the same job, done by a daemon.
#pragma once

#include "src/base/result.h"
#include "src/front/apps/settings.h"
#include "src/front/apps/triangulate_options.h"

namespace tessera {

// What `options`, checked already, were read from is in `settings`. Error usage also for what a daemon cannot do.
Status triangulate_remotely(Settings& settings, const TriangulateOptions& options);

}  // namespace tessera

// The command triangulate, done by a daemon.
#pragma once

#include "src/base/result.h"
#include "src/front/apps/settings.h"
#include "src/front/apps/triangulate_options.h"

namespace tessera::apps {

// `options` were read from `settings` and are checked already. Error usage also for options that a daemon cannot
// follow.
Status triangulate_remotely(Settings& settings, const TriangulateOptions& options);

}  // namespace tessera::apps

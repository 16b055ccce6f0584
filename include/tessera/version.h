// Semantic version: a new major number may break programs, a new minor one adds to them.
#pragma once

#include "tessera/visibility.h"

namespace tessera {

// "1.2.3" of the library that runs.
TESSERA_PUBLIC const char* library_version();

}  // namespace tessera

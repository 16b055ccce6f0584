// Semantic version: a new major number may break programs, a new minor one adds to them.
#pragma once

#include "tessera/visibility.h"

// Of these headers, for the preprocessor: #if TESSERA_VERSION >= TESSERA_VERSION_NUMBER(0, 2, 0)
#define TESSERA_VERSION_MAJOR 0
#define TESSERA_VERSION_MINOR 1
#define TESSERA_VERSION_PATCH 0
#define TESSERA_VERSION_NUMBER(major, minor, patch) ((major)*1000000 + (minor)*1000 + (patch))
#define TESSERA_VERSION TESSERA_VERSION_NUMBER(TESSERA_VERSION_MAJOR, TESSERA_VERSION_MINOR, TESSERA_VERSION_PATCH)

namespace tessera {

// "1.2.3" of the library that runs.
TESSERA_PUBLIC const char* library_version();

}  // namespace tessera

// The version of Tessera, a semantic version: a new major number may break programs, a new minor number adds functions.
#pragma once

#include "tessera/visibility.h"

// The version of these headers, for the preprocessor: #if TESSERA_VERSION >= TESSERA_VERSION_NUMBER(0, 2, 0)
#define TESSERA_VERSION_MAJOR 0
#define TESSERA_VERSION_MINOR 1
#define TESSERA_VERSION_PATCH 0
#define TESSERA_VERSION_NUMBER(major, minor, patch) ((major)*1000000 + (minor)*1000 + (patch))
#define TESSERA_VERSION TESSERA_VERSION_NUMBER(TESSERA_VERSION_MAJOR, TESSERA_VERSION_MINOR, TESSERA_VERSION_PATCH)

namespace tessera {

// Returns the version of the library that the program runs with, as "1.2.3".
TESSERA_PUBLIC const char* library_version();

}  // namespace tessera

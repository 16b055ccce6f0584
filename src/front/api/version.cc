#include "tessera/version.h"

#include "src/job/version.h"

namespace tessera {

const char* library_version() { return version(); }

}  // namespace tessera

// The version of this program and library, as in CMake's project().
#pragma once

namespace tessera {

const char* version();  // "1.2.3"

}  // namespace tessera

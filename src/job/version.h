// The version of this program and library, as CMake's project() has it.
#pragma once

namespace tessera {

const char* version();  // "1.2.3"

}  // namespace tessera

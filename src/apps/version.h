// The version of this program, as CMake's project() has it.
#pragma once

namespace tessera {

constexpr const char* version() { return TESSERA_VERSION; }

}  // namespace tessera

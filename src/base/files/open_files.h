// The number of files that a process may have open at once.
#pragma once

#include <cstdint>

namespace tessera {

std::uint64_t open_files_limit();
// Raises the limit as far as the system allows.
void raise_open_files_limit();

}  // namespace tessera

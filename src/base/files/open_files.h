// How many files a process may have open at once.
#pragma once

#include <cstdint>

namespace tessera {

std::uint64_t open_files_limit();
// As many as the system ever lets it, from here on.
void raise_open_files_limit();

}  // namespace tessera

// Which process a number means: the system gives the numbers of those that have ended to others.
#pragma once

#include <cstdint>
#include <string>

namespace tessera {

// When it began, in clock ticks since the boot. 0 when there is no such process, or the system does not tell.
std::uint64_t process_start(std::int64_t process);
// Of the kernel, unlike any other's. Empty when the system does not tell.
std::string boot_id();

}  // namespace tessera

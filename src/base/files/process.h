// Which process a number means. The system gives the number of a process that has ended to another process.
#pragma once

#include <cstdint>
#include <string>

namespace tessera {

// When a process began, in clock ticks since the boot. 0 when there is no such process, or the system does not tell.
std::uint64_t process_start(std::int64_t process);
// The id of the kernel's boot, unlike any other. Empty when the system does not tell.
std::string boot_id();

}  // namespace tessera

// What this machine offers to one process.
#pragma once

#include <cstdint>
#include <string>

namespace tessera {

// Bytes that can be taken without swapping: the least of MemAvailable and what the memory limits of the control groups
// around this process leave (v1 and v2). 1 GiB when nothing can be read.
std::uint64_t available_memory();

// What a job takes when it is not told: 70 % of that, so that the page cache and others live too.
std::uint64_t default_memory();

// Processors this process may run on: its affinity mask and the control group's quota, rounded up. At least 1.
std::uint32_t usable_processors();

// The highest resident memory of this process so far (VmHWM), in bytes; 0 when it cannot be read.
std::uint64_t peak_memory();

// Of this machine in its network; "node" when it has none.
std::string host_name();

}  // namespace tessera

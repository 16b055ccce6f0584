// What this machine offers to one process.
#pragma once

#include <cstdint>
#include <string>

namespace tessera {

// Returns the bytes that can be taken without swapping: the least of MemAvailable and what the memory limits of this
// process's control groups (v1 and v2) leave. 1 GiB when nothing can be read.
std::uint64_t available_memory();

// Returns the memory for a job without an option for it: 70 % of available_memory(), so that the page cache and other
// programs have memory, too.
std::uint64_t default_memory();

// Returns the number of processors this process may run on: its affinity mask and the control group's quota, rounded
// up. At least 1.
std::uint32_t usable_processors();

// Returns the highest resident memory of this process so far (VmHWM), in bytes; 0 when it cannot be read.
std::uint64_t peak_memory();

// Returns the name of this machine in its network; "node" when it has none.
std::string host_name();

}  // namespace tessera

// Limits of the jobs and uploads of a service.
#pragma once

#include <cstdint>

namespace tessera::service {

struct ServiceLimits {
  std::uint32_t running = 1;                              // jobs at once
  std::uint32_t queued = 10'000;                          // waiting jobs; more: 429
  std::uint32_t jobs_of_a_caller = 1000;                  // accepted or running
  std::uint32_t ended_of_a_caller = 1000;                 // ended jobs that are kept; the oldest of more are forgotten
  std::uint64_t points = 0, disk_bytes = 0;               // of one job; 0: what the machine has
  std::uint64_t reserve_bytes = std::uint64_t{64} << 20;  // of the disk, that jobs and uploads leave free
  std::uint64_t upload_bytes = 0;                         // of all uploads together; 0: what the disk has
  // A job during which the process died is begun again, alone, so that other jobs are not blamed. After this many
  // successive deaths the job has failed, and only a request to resume begins it again.
  std::uint32_t deaths = 3;
};

}  // namespace tessera::service

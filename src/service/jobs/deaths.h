// Counts deaths of a job's process. Jobs that make progress in spite of deaths are not blamed for them.
#pragma once

#include <algorithm>
#include <cstdint>

#include "job_record.pb.h"

namespace tessera::service {

// `done` is the number of tiles that are kept when the process dies. Returns true when it exceeds what any attempt has
// reached by at least a hundredth of the job. So the deaths of a job that always dies at the same place are counted,
// and few numbers are written to disk.
inline bool gets_on(const proto::JobRecord& job, std::uint64_t done, std::uint32_t tiles) {
  const bool died = job.deaths() > 0 || job.reached() > 0;
  return died && done >= job.reached() + std::max<std::uint64_t>(1, tiles / 100);
}

}  // namespace tessera::service

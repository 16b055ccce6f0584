// Jobs during which the process died: those that get on all the same are not to blame.
#pragma once

#include <algorithm>
#include <cstdint>

#include "job_record.pb.h"

namespace tessera {

// `done`: tiles of what outlives the process, so far. Whether that is more than any attempt has done, by a hundredth of
// the job at least: so a job whose process always dies at the same place has its deaths counted, and few are written
// down.
inline bool gets_on(const proto::JobRecord& job, std::uint64_t done, std::uint32_t tiles) {
  const bool died = job.deaths() > 0 || job.reached() > 0;
  return died && done >= job.reached() + std::max<std::uint64_t>(1, tiles / 100);
}

}  // namespace tessera

// Jobs that triangulate regions of raw clouds, and the estimate of their cost.
#pragma once

#include <optional>

#include "src/service/processes/work.h"

namespace tessera {

// As do_work().
Reply<JobDone> do_region(const Workshop& shop, const JobWork& work);

// Estimates the cost of the points in boxes that meet the region; usually not many more are needed. `reason` is set
// when the job is not accepted, or when files must be read before anything is known. Error: as open_regions().
Result<proto::Estimate> region_estimate(const Workshop& shop, const proto::RegionInputs& inputs);

}  // namespace tessera

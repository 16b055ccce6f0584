// Regions of raw clouds, as jobs, and what they would cost.
#pragma once

#include <optional>

#include "src/service/work.h"

namespace tessera {

// As do_work().
Reply<JobDone> do_region(const Workshop& shop, const JobWork& work);

// What the points in boxes that meet the region take: more are needed, most of the time not many. The `reason` of an
// estimate that is not accepted, or of files that have to be read before anything is known. Error as open_regions().
Result<proto::Estimate> region_estimate(const Workshop& shop, const proto::RegionInputs& inputs);

}  // namespace tessera

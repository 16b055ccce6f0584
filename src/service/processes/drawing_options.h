// Converts the inputs of the processes dem, contours and surface to options.
#pragma once

#include "service.pb.h"
#include "src/base/result.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/dem.h"
#include "src/service/processes/convert.h"
#include "src/surface/surface.h"

namespace tessera::service {

// Errors usage, with marks for options. The caller sets `overwrite`.
Result<DemOptions> dem_options(const proto::DemInputs& inputs, const JobShare& share);
Result<ContourOptions> contour_options(const proto::ContoursInputs& inputs, const JobShare& share);
Result<SurfaceOptions> surface_options(const proto::SurfaceInputs& inputs, const JobShare& share);

}  // namespace tessera::service

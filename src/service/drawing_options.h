// What the processes dem, contours and surface are asked to do, from fields to options.
#pragma once

#include "service.pb.h"
#include "src/base/result.h"
#include "src/result/terrain/contours.h"
#include "src/result/terrain/dem.h"
#include "src/service/convert.h"
#include "src/surface/surface.h"

namespace tessera {

// Errors usage, with options marked. `overwrite` is left to the caller.
Result<DemOptions> dem_options(const proto::DemInputs& inputs, const JobShare& share);
Result<ContourOptions> contour_options(const proto::ContoursInputs& inputs, const JobShare& share);
Result<SurfaceOptions> surface_options(const proto::SurfaceInputs& inputs, const JobShare& share);

}  // namespace tessera

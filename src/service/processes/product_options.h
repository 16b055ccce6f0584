// Converts the inputs of the processes alpha, density, volume and voronoi to options.
#pragma once

#include "service.pb.h"
#include "src/base/result.h"
#include "src/result/alpha/alpha_shape.h"
#include "src/result/density/density.h"
#include "src/result/volume/volumes.h"
#include "src/result/voronoi/voronoi.h"
#include "src/service/processes/convert.h"

namespace tessera::service {

// Errors usage, with marks for options. Polygons are checked. The caller sets the files that have them
// (polygon_text.h), and `overwrite`.
Result<AlphaOptions> alpha_options(const proto::AlphaInputs& inputs, const JobShare& share);
Result<density::GridOptions> density_options(const proto::DensityInputs& inputs, const JobShare& share);
Result<VolumeOptions> volume_options(const proto::VolumeInputs& inputs, const JobShare& share);
Result<VoronoiOptions> voronoi_options(const proto::VoronoiInputs& inputs, const JobShare& share);

}  // namespace tessera::service

// The process dem.
#include "src/result/terrain/dem.h"

#include "src/base/files/names.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/drawing_options.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/result_costs.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::string usual_raster(const proto::Inputs& /*inputs*/) { return dem_of_result("").filename().string(); }

std::optional<proto::Problem> check_dem_options(const proto::Inputs& inputs, const JobShare& share) {
  if (const auto bad = problem_if(dem_options(inputs.dem(), share))) return bad;
  return check_ending(inputs, {".tif", ".tiff"});
}

Reply<proto::Estimate> estimate_dem(const Workshop& shop, const proto::Inputs& inputs,
                                    std::optional<proto::Problem>& refused) {
  const std::string name = result_read(inputs);
  const auto manifest = shop.results.manifest(name, version_read(inputs));
  if (!manifest) return problem_of(manifest.error());
  const auto options = dem_options(inputs.dem(), shop.share);
  if (!options) return problem_of(options.error());
  proto::Estimate estimate;
  refused = check_costs(*manifest.value(), options.value(), shop.limits, shop.data, estimate);
  if (auto none = no_heights(*manifest.value(), name)) refused = std::move(none);
  return judged(std::move(estimate), refused);
}

Reply<JobDone> run_dem(const Workshop& shop, const JobWork& work) {
  return draw(shop, work, dem_options(work.job.inputs().dem(), shop.share), write_dem);
}

}  // namespace

constinit const Process dem_process{
    .name = "dem",
    .title = "Raster",
    .description =
        "Draws the surface of a 2D result as a raster, a Cloud Optimized GeoTIFF. With the output dem.tif it is also a "
        "map.",
    .outcome = "The file, by reference",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .costs = Process::Costs::before_it_waits,
    .usual_output = usual_raster,
    .check_options = check_dem_options,
    .estimate = estimate_dem,
    .run = run_dem};

}  // namespace tessera::service

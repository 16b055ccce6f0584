// The process contours.
#include "src/result/terrain/contours.h"

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

std::string usual_lines(const proto::Inputs& /*inputs*/) { return contours_of_result("").filename().string(); }

std::optional<proto::Problem> check_contour_options(const proto::Inputs& inputs, const JobShare& share) {
  if (const auto bad = problem_if(contour_options(inputs.contours(), share))) return bad;
  return check_ending(inputs, {".gpkg", ".geojson"});
}

Reply<proto::Estimate> estimate_contours(const Workshop& shop, const proto::Inputs& inputs,
                                         std::optional<proto::Problem>& refused) {
  const std::string name = result_read(inputs);
  const auto manifest = shop.results.manifest(name, version_read(inputs));
  if (!manifest) return problem_of(manifest.error());
  const auto options = contour_options(inputs.contours(), shop.share);
  if (!options) return problem_of(options.error());
  proto::Estimate estimate;
  refused = check_costs(*manifest.value(), options.value(), shop.results.folder(name, version_read(inputs)),
                        shop.limits, shop.data, estimate);
  if (auto none = no_heights(*manifest.value(), name)) refused = std::move(none);
  return judged(std::move(estimate), refused);
}

Reply<JobDone> run_contours(const Workshop& shop, const JobWork& work) {
  return draw(shop, work, contour_options(work.job.inputs().contours(), shop.share), write_contours);
}

}  // namespace

constinit const Process contours_process{
    .name = "contours",
    .title = "Contour lines",
    .description =
        "Draws the contour lines of a 2D result. With the output contours.gpkg they are also a collection of features.",
    .outcome = "The file, by reference",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .costs = Process::Costs::before_it_waits,
    .usual_output = usual_lines,
    .check_options = check_contour_options,
    .estimate = estimate_contours,
    .run = run_contours};

}  // namespace tessera::service

// The process alpha.
#include "src/result/alpha/alpha_shape.h"

#include "src/service/processes/job_work.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/product_options.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::optional<proto::Problem> check_alpha_options(const proto::Inputs& inputs, const JobShare& share) {
  if (auto bad = problem_if(alpha_options(inputs.alpha(), share))) return bad;
  return check_ending(inputs, {".ply", ".gpkg", ".geojson", ".fgb"});
}

Reply<JobDone> run_alpha(const Workshop& shop, const JobWork& work) {
  return draw(shop, work, alpha_options(work.job.inputs().alpha(), shop.share), write_alpha_shape);
}

}  // namespace

constinit const Process alpha_process{
    .name = "alpha",
    .title = "Alpha shape",
    .description =
        "Writes the alpha shape of a result: the boundary of all cells of small circumradius, as .ply, or of a 2D "
        "result as polygons in .gpkg, .geojson or .fgb.",
    .outcome = "The file, by reference, and the radius",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .check_options = check_alpha_options,
    .run = run_alpha};

}  // namespace tessera::service

// The process density.
#include "src/result/density/density.h"

#include <optional>
#include <string>
#include <utility>

#include "src/service/processes/costs.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/product_options.h"
#include "src/service/processes/result_costs.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::optional<proto::Problem> check_density_options(const proto::Inputs& inputs, const JobShare& share) {
  if (auto bad = problem_if(density_options(inputs.density(), share))) return bad;
  return check_ending(inputs, {".tif", ".tiff", ".npy", ".h5", ".hdf5", ".fits"});
}

std::optional<proto::Problem> check_density(const Workshop& shop, const proto::Inputs& inputs) {
  const auto manifest = shop.results.manifest(result_read(inputs), version_read(inputs));
  if (!manifest) return problem_of(manifest.error());
  const int numbers = inputs.density().bbox_size(), needed = 2 * manifest.value()->dimension;
  if (numbers == 0 || numbers == needed) return std::nullopt;
  return problem(400,
                 "bbox: has " + std::to_string(numbers) + " numbers, but a " +
                     std::to_string(manifest.value()->dimension) + "D result takes " + std::to_string(needed),
                 Errc::usage);
}

Reply<proto::Estimate> estimate_density(const Workshop& shop, const proto::Inputs& inputs,
                                        std::optional<proto::Problem>& refused) {
  const auto manifest = shop.results.manifest(result_read(inputs), version_read(inputs));
  if (!manifest) return problem_of(manifest.error());
  const auto options = density_options(inputs.density(), shop.share);
  if (!options) return problem_of(options.error());
  proto::Estimate estimate;
  refused = check_costs(*manifest.value(), options.value(), shop.limits, shop.data, estimate);
  return judged(std::move(estimate), refused);
}

Reply<JobDone> run_density(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().density();
  auto options = density_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  options.value().progress = percentage(work);
  options.value().overwrite = true;  // files of an earlier attempt; existing exports were checked before
  const auto folder = shop.results.unfinished_export(inputs.triangulation(), work.job.id());
  const auto made = written_aside(shop, folder, work, [&] {
    return density::write_grid(shop.results.folder(inputs.triangulation(), inputs.version()), folder / inputs.output(),
                               options.value(), work.ledger.token());
  });
  if (!made) return problem_of(made.error());
  if (!made.value().facts.note.empty()) work.log("note: " + made.value().facts.note);
  return done_with(folder, to_json(made.value()), inputs.output());
}

}  // namespace

constinit const Process density_process{
    .name = "density",
    .title = "Density or field",
    .description =
        "Puts the density of the points of a result, or a field, on a grid of pixels or voxels: a .npy, .h5 or "
        ".fits, or of a 2D result a .tif.",
    .outcome = "The file, by reference, and the mass of the points and of the grid",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::file,
    .costs = Process::Costs::before_it_waits,
    .check_options = check_density_options,
    .check = check_density,
    .estimate = estimate_density,
    .run = run_density};

}  // namespace tessera::service

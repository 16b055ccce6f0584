// The process measure.
#include "src/result/measure/measure.h"

#include "src/job/version.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

std::optional<proto::Problem> check_measure(const proto::Inputs& inputs, const JobShare& share) {
  return problem_if(measure_options(inputs.measure(), share));
}

Reply<JobDone> run_measure(const Workshop& shop, const JobWork& work) {
  const std::string name = result_read(work.job.inputs());
  auto options = measure_options(work.job.inputs().measure(), shop.share);
  if (!options) return problem_of(options.error());
  options.value().command = ResultFolders::command_of(work.job);
  options.value().software_version = version();
  options.value().lock = lock_of_unfinished(shop, work.ledger.token());
  options.value().progress = percentage(work);
  auto measured = measure(shop.results.folder(name), options.value(), work.ledger.token());
  if (!measured) return problem_of(measured.error());
  if (!measured.value().note.empty()) work.log("note: " + measured.value().note);
  measured.value().folder = name;
  return JobDone{to_json(measured.value()) + "\n", 0, {}};
}

}  // namespace

constinit const Process measure_process{
    .name = "measure",
    .title = "Measure",
    .description =
        "Computes columns of cells and vertices: volumes and shapes of cells, Voronoi cells and densities of vertices. "
        "They become a new version of the result, which only its owner or an admin may have made.",
    .outcome = "The names of the columns, and the sum of the volumes",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::columns,
    .check_options = check_measure,
    .run = run_measure};

}  // namespace tessera::service

// The process verify.
#include "src/result/verify/verify.h"

#include <optional>

#include "src/base/option.h"
#include "src/job/report/human.h"
#include "src/service/problem.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

// The problem of a comparison with CGAL, which is made in memory, when it needs more memory than there is.
std::optional<proto::Problem> check_verify(const Workshop& shop, const proto::Inputs& all) {
  const auto& inputs = all.verify();
  if (!inputs.against_cgal()) return std::nullopt;
  const auto manifest = shop.results.manifest(inputs.triangulation(), inputs.version());
  if (!manifest) return problem_of(manifest.error());
  // CGAL's cells and vertices, and the sorted sets of both.
  const std::uint64_t vertex_bytes = manifest.value()->dimension == 3 ? 1'200 : 400;
  const auto bytes = manifest.value()->vertices * vertex_bytes;
  if (bytes <= shop.share.memory_bytes) return std::nullopt;
  return problem(422,
                 option("against-cgal") + ": " + grouped(manifest.value()->vertices) + " vertices need " +
                     human_bytes(bytes) + " of memory; a job has " + human_bytes(shop.share.memory_bytes) + " here",
                 Errc::memory);
}

Reply<JobDone> verify(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().verify();
  auto options = verify_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  options.value().scratch = work.scratch;
  if (const auto problem = check_verify(shop, work.job.inputs())) return *problem;
  const auto report = tessera::verify(shop.results.folder(inputs.triangulation(), inputs.version()), options.value(),
                                      work.ledger.token());
  if (!report) return problem_of(report.error());
  const auto& found = report.value();
  for (const auto& passed : found.passed) work.log("ok  " + passed);
  return JobDone{to_json(found, inputs.triangulation()) + "\n", 0, {}};
}

std::optional<proto::Problem> check_verify_options(const proto::Inputs& inputs, const JobShare& share) {
  return problem_if(verify_options(inputs.verify(), share));
}

}  // namespace

constinit const Process verify_process{
    .name = "verify",
    .title = "Verify",
    .description = "Proves that a result is the Delaunay triangulation of its points.",
    .outcome = "What was proved",
    .reads = Process::Reads::a_result,
    .check_options = check_verify_options,
    .check = check_verify,
    .run = verify};

}  // namespace tessera::service

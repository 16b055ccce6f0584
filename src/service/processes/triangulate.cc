// The process triangulate.
#include <algorithm>
#include <optional>
#include <utility>

#include "src/base/files/there.h"
#include "src/job/estimate.h"
#include "src/job/job.h"
#include "src/job/job_report.h"
#include "src/job/open_cloud.h"
#include "src/job/report/human.h"
#include "src/job/report/summary.h"
#include "src/job/result_folder.h"
#include "src/service/problem.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/disk_watch.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

constexpr std::size_t files_opened_max = 10'000;  // while a request waits: some seconds

// The summary of a result that was complete when its job was continued.
Result<JobSummary> summary_of_stored(const Workshop& shop, const JobOptions& options, const proto::JobRecord& job) {
  const auto unfinished = shop.results.unfinished(job.id());
  BOOST_OUTCOME_TRY(unpublished, is_there(unfinished));
  const auto folder = unpublished ? unfinished : shop.results.folder(job.triangulation());
  BOOST_OUTCOME_TRY(manifest, read_manifest(folder));
  auto summary = summary_of(options, job.triangulation(), manifest, RunSummary{});
  add_duplicates(summary, manifest);
  if (manifest.digest) summary.digest = digest_text(*manifest.digest);
  for (const auto& [phase, seconds] : manifest.seconds) {
    summary.seconds.emplace_back(phase, seconds);
    summary.total_s += seconds;
  }
  return summary;
}

Reply<JobDone> triangulation_done(JobSummary summary, const proto::JobRecord& job) {
  summary.out = job.triangulation();
  return JobDone{summary_json(summary) + "\n", summary.points_read, summary.seconds};
}

// The problem of a failed triangulation. Also removes what is of no further use.
proto::Problem failed_with(const Error& error, const std::optional<proto::Problem>& refused, ResultFolder& folder,
                           const Workshop& shop, const JobWork& work) {
  if (error.code == Errc::interrupted) {
    work.log(folder.abandon_unless_resumable() ? "interrupted; the work done so far is kept"
                                               : "interrupted before there was anything to keep");
    return problem_of(error);
  }
  folder.abandon();
  // A run that failed for lack of disk or memory can continue when there is more, unless it has exceeded its own bound
  // of disk. Any other run would fail again, and is removed.
  if (work.ledger.reason() ? error.code == Errc::memory : error.code != Errc::io && error.code != Errc::memory) {
    if (const Status gone = shop.results.drop_unfinished(work.job.id()); !gone) work.log(gone.error().where);
  }
  return refused ? *refused : problem_of(error);
}

Reply<JobDone> triangulate(const Workshop& shop, const JobWork& work) {
  const auto& job = work.job;
  const auto& inputs = job.inputs().triangulate();
  auto options = job_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  if (shop.limits.running > 0 && !inputs.has_threads())
    options.value().threads = std::max(options.value().threads, shop.engine.threads() / shop.limits.running);
  options.value().command = ResultFolders::command_of(job);
  options.value().log = work.log;
  options.value().cloud.spool_bytes_max = unpacked_max(shop.limits, shop.data);
  // An earlier process may have completed and published the result just before it ended.
  const auto path = shop.results.unfinished(job.id());
  const auto published = job.starts() > 1 ? shop.results.is_published(job.id(), job.triangulation()) : false;
  if (!published) return problem_of(published.error());
  if (published.value()) {
    auto summary = summary_of_stored(shop, options.value(), job);
    if (!summary) return problem_of(summary.error());
    return triangulation_done(std::move(summary).value(), job);
  }
  auto folder = ResultFolder::inspect(path, true, false);
  if (!folder) return problem_of(folder.error());
  folder.value().lock_with(lock_of_unfinished(shop, work.ledger.token()));
  std::optional<proto::Problem> refused;
  const auto open = [&](JobOptions& opened, const std::stop_token& stop) -> Result<Cloud> {
    BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
    BOOST_OUTCOME_TRY(cloud, open_cloud(files, opened, stop));
    proto::Estimate estimate;
    if (!folder.value().resuming())
      refused = check_costs(cloud, opened, shop.limits, shop.data, estimate, shop.engine.shares());
    if (refused) return error(Errc::memory, refused->detail());
    for (const auto& warning : cloud.warnings()) work.log("warning: " + warning);
    return std::move(cloud);
  };
  if (folder.value().resuming()) work.log("continues the work of an earlier start of this job");
  DiskWatch watch(path, work.ledger);
  auto summary = run_job(shop.engine, options.value(), open, folder.value(), work.progress, work.ledger.token());
  if (const auto bounded = watch.finish(); !bounded && summary) summary = bounded.error();
  if (!summary) return failed_with(work.ledger.reason().value_or(summary.error()), refused, folder.value(), shop, work);
  if (summary.value()) return triangulation_done(*std::move(summary).value(), job);
  auto stored = summary_of_stored(shop, options.value(), job);
  if (!stored) return problem_of(stored.error());
  return triangulation_done(std::move(stored).value(), job);
}

Reply<proto::Estimate> estimate_triangulate(const Workshop& shop, const proto::Inputs& all,
                                            std::optional<proto::Problem>& refused) {
  const auto& inputs = all.triangulate();
  auto options = job_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  proto::Estimate estimate;
  const auto looked = [&]() -> Status {
    BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
    if (files.size() > files_opened_max) {
      estimate.set_reason("there are more than " + grouped(files_opened_max) +
                          " files; they are measured when the job runs");
      return success();
    }
    BOOST_OUTCOME_TRY(packed, any_packed(files));
    if (packed) {
      estimate.set_reason("compressed files are measured only when the job runs");
      return success();
    }
    BOOST_OUTCOME_TRY(cloud, open_cloud(files, options.value(), Ledger::token_of_thread()));
    refused = check_costs(cloud, options.value(), shop.limits, shop.data, estimate, shop.engine.shares());
    return success();
  }();
  if (!looked && !Ledger::reason_of_thread()) return in_callers_words(shop, problem_of_inputs(looked.error()));
  if (!looked) estimate.set_reason("the files take too long to measure now; they are measured when the job runs");
  if (refused) estimate.set_reason(refused->detail());
  estimate.set_accepted(!refused);
  return estimate;
}

}  // namespace

constinit const Process triangulate_process{
    .name = "triangulate",
    .title = "Triangulate",
    .description = "The exact Delaunay triangulation of point clouds, in tiles.",
    .outcome = "The triangulation, by reference",
    .makes = Process::Makes::result,
    .costs = Process::Costs::before_it_waits,
    .estimate = estimate_triangulate,
    .run = triangulate};

}  // namespace tessera::service

#include "src/service/work.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <system_error>

#include "src/base/files/there.h"
#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/job/describe.h"
#include "src/job/estimate.h"
#include "src/job/job.h"
#include "src/job/job_report.h"
#include "src/job/open_cloud.h"
#include "src/job/report/human.h"
#include "src/job/report/summary.h"
#include "src/job/result_folder.h"
#include "src/result/verify/verify.h"
#include "src/service/costs.h"
#include "src/service/disk_watch.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/service/work_exports.h"
#include "src/service/work_region.h"

namespace tessera {
namespace {

constexpr std::size_t described_at_once_max = 10'000;  // files: some seconds

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

Reply<JobDone> done_with(JobSummary summary, const proto::JobRecord& job) {
  summary.out = job.triangulation();
  return JobDone{summary_json(summary) + "\n", summary.points_read, summary.seconds};
}

// The problem of a failed triangulation. Also removes what is of no further use.
proto::Problem failed_with(const Error& error, const std::optional<proto::Problem>& refused, ResultFolder& folder,
                           const Workshop& shop, const JobWork& work) {
  if (error.code == Errc::interrupted) {
    work.log(folder.abandon_unless_resumable() ? "interrupted; what is done stays"
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
  options.value().command = Results::command_of(job);
  options.value().log = work.log;
  options.value().cloud.spool_bytes_max = unpacked_max(shop.limits, shop.data);
  // An earlier process may have completed and published the result just before it ended.
  const auto path = shop.results.unfinished(job.id());
  const auto published = job.starts() > 1 ? shop.results.is_published(job.id(), job.triangulation()) : false;
  if (!published) return problem_of(published.error());
  if (published.value()) {
    auto summary = summary_of_stored(shop, options.value(), job);
    if (!summary) return problem_of(summary.error());
    return done_with(std::move(summary).value(), job);
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
  if (folder.value().resuming()) work.log("goes on with what is there");
  DiskWatch watch(path, work.ledger);
  auto summary = run_job(shop.engine, options.value(), open, folder.value(), work.progress, work.ledger.token());
  if (const auto bounded = watch.finish(); !bounded && summary) summary = bounded.error();
  if (!summary) return failed_with(work.ledger.reason().value_or(summary.error()), refused, folder.value(), shop, work);
  if (summary.value()) return done_with(*std::move(summary).value(), job);
  auto stored = summary_of_stored(shop, options.value(), job);
  if (!stored) return problem_of(stored.error());
  return done_with(std::move(stored).value(), job);
}

Reply<JobDone> verify(const Workshop& shop, const JobWork& work) {
  const auto& inputs = work.job.inputs().verify();
  auto options = verify_options(inputs, shop.share);
  if (!options) return problem_of(options.error());
  options.value().scratch = work.scratch;
  if (const auto problem = check_verify(shop, inputs)) return *problem;
  const auto report =
      tessera::verify(shop.results.folder(inputs.triangulation()), options.value(), work.ledger.token());
  if (!report) return problem_of(report.error());
  const auto& found = report.value();
  for (const auto& passed : found.passed) work.log("ok  " + passed);
  return JobDone{to_json(found, inputs.triangulation()) + "\n", 0, {}};
}

}  // namespace

Result<std::optional<proto::Problem>> takes_too_long(const Workshop& shop, const proto::InfoInputs& inputs,
                                                     std::uint64_t points_max) {
  using Refused = std::optional<proto::Problem>;
  if (!inputs.triangulation().empty()) return Refused{};
  BOOST_OUTCOME_TRY(cloud, cloud_of(inputs));
  BOOST_OUTCOME_TRY(options, job_options(cloud, shop.share));
  const auto found = shop.roots.files(list_of(inputs.inputs()), inputs.recursive());
  if (Ledger::reason_of_thread()) return Refused(needs_a_job("inputs: so many files"));
  if (!found) return found.error();
  const auto& files = found.value();
  if (files.size() > described_at_once_max) return Refused(needs_a_job("inputs: " + grouped(files.size()) + " files"));
  BOOST_OUTCOME_TRY(packed, any_packed(files));
  if (packed) return Refused(needs_a_job("inputs: compressed files"));
  if (!inputs.stats()) return Refused{};
  BOOST_OUTCOME_TRY(opened, open_cloud(files, options, Ledger::token_of_thread()));
  const auto points = expected_points(opened.files());
  if (points > points_max) return Refused(needs_a_job("inputs: " + grouped(points) + " points"));
  return Refused{};
}

Result<std::string> describe_inputs(const Workshop& shop, const proto::InfoInputs& inputs,
                                    const std::stop_token& stop) {
  DescribeOptions how{.json = true, .statistics = inputs.stats(), .names = field_name};
  if (!inputs.triangulation().empty()) {
    if (inputs.inputs_size() > 0) return error(Errc::usage, "inputs: give them, or a triangulation, not both");
    BOOST_OUTCOME_TRY(there, shop.results.exists(inputs.triangulation()));
    if (!there) return error(Errc::usage, "triangulation: there is none called '" + inputs.triangulation() + "'");
    return describe_result(shop.results.folder(inputs.triangulation()), true);
  }
  BOOST_OUTCOME_TRY(cloud, cloud_of(inputs));
  BOOST_OUTCOME_TRY(options, job_options(cloud, shop.share));
  BOOST_OUTCOME_TRY(files, shop.roots.files(list_of(inputs.inputs()), inputs.recursive()));
  options.cloud.spool_folder = shop.data;
  options.cloud.spool_bytes_max = unpacked_max(shop.limits, shop.data);

  auto described = describe(files, std::move(options), how, stop);
  if (described.error) return *described.error;
  return std::move(described.text);
}

std::optional<proto::Problem> check_verify(const Workshop& shop, const proto::VerifyInputs& inputs) {
  if (!inputs.against_cgal()) return std::nullopt;
  const auto manifest = shop.results.manifest(inputs.triangulation());
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

LockOptions lock_of_unfinished(const Workshop& shop, const std::stop_token& stop) {
  static constexpr std::chrono::milliseconds pause{200};
  const auto until = std::chrono::steady_clock::now() + shop.data_lease * 3 / 2;
  const auto wait = [stop, until](const Error&) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    stopped.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); });
    return !stop.stop_requested() && std::chrono::steady_clock::now() < until;
  };
  return {.heartbeat = shop.data_lease / 12, .silence_max = shop.data_lease, .locked = wait};
}

namespace {

Reply<JobDone> work_of_kind(const Workshop& shop, const JobWork& work) {
  switch (work.job.inputs().of_case()) {
    case proto::Inputs::kTriangulate:
      return triangulate(shop, work);
    case proto::Inputs::kVerify:
      return verify(shop, work);
    case proto::Inputs::kExport:
      return do_export(shop, work);
    case proto::Inputs::kDem:
      return do_dem(shop, work);
    case proto::Inputs::kContours:
      return do_contours(shop, work);
    case proto::Inputs::kSurface:
      return do_surface(shop, work);
    case proto::Inputs::kRegion:
      return do_region(shop, work);
    default: {
      auto text = describe_inputs(shop, work.job.inputs().info(), work.ledger.token());
      if (!text) return problem_of(text.error());
      return JobDone{std::move(text).value(), 0, {}};
    }
  }
}

}  // namespace

Reply<JobDone> do_work(const Workshop& shop, const JobWork& work) {
  const Ledger::Use use(&work.ledger);
  auto done = [&]() -> Reply<JobDone> {
    try {
      return work_of_kind(shop, work);
    } catch (const Stopped& stopped) {
      return problem_of(error(Errc::interrupted, stopped.what()));
    }
  }();
  // An exceeded bound causes many different errors; the ledger's reason says what to change.
  if (const auto reason = work.ledger.reason(); reason && !done) return problem_of(*reason);
  return done;
}

}  // namespace tessera

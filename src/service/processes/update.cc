// The process update.
#include "src/delaunay/update/update.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/files/update_names.h"
#include "src/base/json/json_text.h"
#include "src/job/engine_steps.h"
#include "src/job/told_update.h"
#include "src/job/version.h"
#include "src/result/new_version.h"
#include "src/result/version_log.h"
#include "src/service/problem.h"
#include "src/service/processes/disk_watch.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/made_file.h"
#include "src/service/processes/result_costs.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/update_costs.h"
#include "src/service/processes/update_inputs.h"
#include "src/service/processes/workshop.h"

namespace tessera::service {
namespace {

using UpdateJson = nlohmann::ordered_json;

std::optional<proto::Problem> check_update_options(const proto::Inputs& inputs, const JobShare& share) {
  return problem_if(update_request(inputs.update(), share));
}

std::optional<proto::Problem> check_update(const Workshop& shop, const proto::Inputs& inputs) {
  const std::string name = result_read(inputs);
  const auto manifest = shop.results.manifest(name);
  if (!manifest) return problem_of(manifest.error());
  // The sentence names the result as the caller does.
  if (const auto changeable = check_changeable("'" + name + "'", *manifest.value()); !changeable)
    return problem(400, "triangulation: " + changeable.error().where, Errc::usage);
  if (inputs.update().inputs_size() == 0) return std::nullopt;
  return check_files(shop, inputs.update().inputs(), inputs.update().recursive());
}

// Names the result as callers do.
Error in_words(const Workshop& shop, const proto::JobRecord& job, Error failed) {
  const std::string name = result_read(job.inputs());
  const auto replace = [&](const std::string& path, const std::string& word) {
    for (auto at = failed.where.find(path); at != std::string::npos; at = failed.where.find(path, at + word.size()))
      failed.where.replace(at, path.size(), word);
  };
  replace(shop.results.folder(name).string(), "triangulation '" + name + "'");
  replace(update_run_folder(shop.results.unfinished(job.id())).string(), "the work so far");
  return failed;
}

// What is told of a change whose job has ended after the change was made, and before that was written down.
Result<std::optional<UpdateJson>> told_if_made(const Workshop& shop, const proto::JobRecord& job) {
  const std::optional<UpdateJson> none;
  if (job.starts() < 2) return none;
  if (makes_result(job.inputs())) {
    const auto unfinished = shop.results.unfinished(job.id());
    BOOST_OUTCOME_TRY(whole, is_there(unfinished));
    BOOST_OUTCOME_TRY(published, shop.results.is_published(job.id(), job.triangulation()));
    if (!whole && !published) return none;
    BOOST_OUTCOME_TRY(manifest, read_manifest(whole ? unfinished : shop.results.folder(job.triangulation())));
    return std::optional(told_of_made(entry_of(manifest, 0), job.triangulation()));
  }
  BOOST_OUTCOME_TRY(versions, tell_versions(shop.results.folder(job.triangulation())));
  const auto made = std::ranges::find_if(
      versions.versions, [&](const ToldVersion& version) { return ResultFolders::is_of(version.entry.command, job); });
  if (made == versions.versions.end()) return none;
  BOOST_OUTCOME_TRYV(
      mend_master(shop.results.folder(job.triangulation()), lock_of_unfinished(shop, Ledger::token_of_thread())));
  return std::optional(told_of_made(made->entry, job.triangulation()));
}

UpdateOptions options_of_update(const Workshop& shop, const JobWork& work, const UpdateRequest& request) {
  const auto& job = work.job;
  UpdateOptions options{.threads = request.share.threads,
                        .resume = !job.inputs().update().dry_run(),
                        .lock = lock_of_unfinished(shop, work.ledger.token()),
                        .progress = percentage(work),
                        .dry_run = job.inputs().update().dry_run(),
                        .command = ResultFolders::command_of(job),
                        .software_version = version()};
  options.run = update_run_folder(shop.results.unfinished(job.id()));
  if (makes_result(job.inputs())) options.to = shop.results.unfinished(job.id());
  // The command of a result tells who its owner is, and that stays.
  options.keep_command = options.to.empty();
  options.version = {.lock = options.lock, .keep = request.keep};
  return options;
}

Result<UpdateJson> change_result(const Workshop& shop, const JobWork& work, const UpdateRequest& request) {
  const std::string name = result_read(work.job.inputs());
  BOOST_OUTCOME_TRY(made, read_change_of_result(shop, work, request));
  BOOST_OUTCOME_TRY(manifest, shop.results.manifest(name));
  UpdateOptions options = options_of_update(shop, work, request);
  options.inputs = std::move(made.inputs);
  // A dry run begins anew.
  if (options.dry_run) {
    BOOST_OUTCOME_TRYV(shop.results.drop_unfinished(work.job.id()));
  }
  BOOST_OUTCOME_TRY(begun, is_there(options.run));
  if (begun) work.log("continues the work of an earlier start of this job");
  EngineStages stages(
      shop.engine,
      {.threads = request.share.threads, .memory_bytes = request.share.memory_bytes, .resumable = options.resume},
      work.progress);
  DiskWatch watch(options.run, work.ledger);
  auto updated = update_result(shop.results.folder(name), made.change, options, stages, work.ledger.token());
  const Status bounded = watch.finish();
  BOOST_OUTCOME_TRY(done, std::move(updated));
  // A new version is there for good, whatever it has taken; what has no name yet can still be refused.
  if (!bounded && !options.to.empty()) return bounded.error();
  return told_of(done, {.output = work.job.triangulation(),
                        .dry_run = options.dry_run,
                        .added = made.change.add.size(),
                        .dimension = manifest->dimension,
                        .memory_bytes = request.share.memory_bytes,
                        .threads = request.share.threads});
}

Reply<JobDone> run_update(const Workshop& shop, const JobWork& work) {
  const auto request = update_request(work.job.inputs().update(), shop.share);
  if (!request) return problem_of(request.error());
  auto made = told_if_made(shop, work.job);
  if (!made) return problem_of(made.error());
  if (made.value()) {
    if (const Status gone = shop.results.drop_change(work.job.id()); !gone) work.log(gone.error().where);
    return JobDone{json_text(*made.value()) + "\n", 0, {}};
  }
  auto told = change_result(shop, work, request.value());
  if (told) return JobDone{json_text(told.value()) + "\n", 0, {}};
  const auto reason = work.ledger.reason();
  const Error failed = reason.value_or(told.error());
  // Such a job can go on when there is more disk or memory, unless it has exceeded its own bound. Any other job would
  // fail again.
  const bool later =
      failed.code == Errc::interrupted || failed.code == Errc::io || (failed.code == Errc::memory && !reason);
  if (later) {
    work.log("the work done so far is kept, if there is any");
  } else if (const Status gone = shop.results.drop_unfinished(work.job.id()); !gone) {
    work.log(gone.error().where);
  }
  return problem_of(in_words(shop, work.job, failed));
}

}  // namespace

constinit const Process update_process{
    .name = "update",
    .title = "Update",
    .description =
        "Removes points of a result and adds others, at the cost of what changes. The result gets a new version, which "
        "only its owner or an admin may make, and is read at the version before until then. With an output there is a "
        "new result.",
    .outcome = "The new version or result, by reference, and what has changed",
    .reads = Process::Reads::a_result,
    .makes = Process::Makes::change,
    .costs = Process::Costs::before_it_waits,
    .check_options = check_update_options,
    .check = check_update,
    .estimate = estimate_update,
    .run = run_update};

}  // namespace tessera::service

#include "src/job/job.h"

#include <malloc.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/files/there.h"
#include "src/base/option.h"
#include "src/delaunay/duplicates.h"
#include "src/input/cloud/settle_period.h"
#include "src/job/job_report.h"
#include "src/job/machine.h"
#include "src/job/open_cloud.h"
#include "src/job/report/human.h"
#include "src/result/store/duplicate_rows.h"
#include "src/tiling/kept_points.h"

namespace tessera {
namespace {

// Returns what differs between the input files of then and now; empty when nothing does.
template <class Inputs>
std::string difference(const Inputs& inputs, const Cloud& cloud) {
  if (inputs.size() != cloud.files().size()) return "other input files";
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto& then = inputs[i];
    const auto& now = cloud.files()[i];
    if (then.path != now.path.string()) return "other input files";
    if (then.bytes != now.bytes || then.modified_ns != now.modified_ns)
      return "another " + then.path + ": it has changed since";
  }
  return {};
}

// A resumed run must be the same job on the same files; else its tiles would not fit together.
Status check_same_job(const RoutedCloud& run, const Cloud& cloud, const std::string& key, const ResultFolder& folder) {
  const auto refuse = [&](const std::string& reason) {
    return error(Errc::usage, folder.path().string() + ": cannot be resumed: " + reason);
  };
  if (run.options_key != key) return refuse("the unfinished run was started with other options");
  const auto reason = difference(run.inputs, cloud);
  if (!reason.empty()) return refuse("the unfinished run was started with " + reason);
  return success();
}

// A finished result must be what was asked for, as far as its manifest tells.
Status check_finished(const Cloud& cloud, const ResultFolder& folder) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(folder.path()));
  const auto reason = difference(manifest.inputs, cloud);
  if (reason.empty()) return success();
  return error(Errc::usage, folder.path().string() + ": holds a finished result of " + reason +
                                ": there is nothing to resume; " + option("overwrite", "true") + " replaces it");
}

// Returns the routed points: those of the run that is resumed, or of a new run.
Result<RoutedCloud> routed_run(const Engine& engine, const JobOptions& options, const Cloud& cloud,
                               ResultFolder& folder, Progress& progress, const std::stop_token& stop) {
  const auto key = options_key(options);
  if (folder.resuming()) {
    BOOST_OUTCOME_TRY(run, open_run(folder.run()));
    BOOST_OUTCOME_TRYV(check_same_job(run, cloud, key, folder));
    return std::move(run);
  }
  BOOST_OUTCOME_TRY(limit, tile_limit(options, cloud, engine.shares()));
  progress.phase = Phase::routing;
  const RouteOptions route_options{.kind = options.partition,
                                   .max_points_per_tile = limit,
                                   .tiles = options.tiles,
                                   .memory_bytes = options.memory_bytes,
                                   .options_key = key};
  const auto router = engine.router(options.memory_bytes);
  BOOST_OUTCOME_TRY(routed, route(cloud, folder.new_run(), route_options, progress, stop, router.get()));
  BOOST_OUTCOME_TRYV(folder.accept_new_run());
  routed.folder = folder.run();
  return std::move(routed);
}

// Returns the seconds by name of phase, in order.
std::vector<std::pair<std::string, double>> seconds_of_phases(double routing_s, const StepSeconds& tiles,
                                                              double finishing_s) {
  std::map<Phase, double> seconds{{Phase::routing, routing_s}, {Phase::finishing, finishing_s}};
  for (const PhaseRow& row : phase_table) {
    if (row.program == ProgramKind::delaunay) seconds[row.phase] = tiles.of(row.step);
  }
  std::vector<std::pair<std::string, double>> named;
  for (const auto& [phase, took_s] : seconds) named.emplace_back(name_of(phase), took_s);
  return named;
}

// Numbers threads from 0. Their numbers in `spans` count all threads that have worked for any job of this process.
std::vector<PhaseSpan> with_threads_from_0(std::vector<PhaseSpan> spans) {
  std::map<std::uint32_t, std::uint32_t> numbers;
  for (const PhaseSpan& span : spans) numbers[span.thread] = 0;
  for (std::uint32_t next = 0; auto& [thread, number] : numbers) number = next++;
  for (PhaseSpan& span : spans) span.thread = numbers[span.thread];
  return spans;
}

Result<JobSummary> make_result(Engine& engine, const JobOptions& options, Cloud cloud, ResultFolder& folder,
                               Progress& progress, const std::stop_token& stop) {
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - progress.started).count();
  };
  const double began_s = elapsed_s();
  BOOST_OUTCOME_TRY(run, routed_run(engine, options, cloud, folder, progress, stop));
  auto warnings = cloud.warnings();
  for (auto& sentence : sentences_of_period(run.counts, run.partition.period()))
    warnings.push_back(std::move(sentence));
  progress.map.begin(layout_of(run.partition, run.bounds), run.tile_points);
  cloud = {};  // also removes what was unpacked for it: tiles need that disk space
  const double routed_s = elapsed_s();
  if (options.log) {
    options.log("routed " + grouped(run.counts.read) + " points into " + std::to_string(run.partition.tiles()) +
                " tiles");
  }

  BOOST_OUTCOME_TRY(tiles, engine.run(run, folder.path(), options, progress, stop));
  const double ran_s = elapsed_s();

  progress.phase = Phase::finishing;
  malloc_trim(0);  // frees what the tiles have left behind, before a large manifest is made
  auto manifest = manifest_of(options, run, tiles);
  auto summary = summary_of(options, folder.path(), manifest, tiles);
  summary.warnings = std::move(warnings);
  DuplicateSort duplicates(folder.run(), options.memory_bytes / 4);
  std::optional<DuplicateRowSort> rows;
  if (const std::size_t width = row_bytes(run.schema); width > 0)
    rows.emplace(folder.run(), options.memory_bytes / 4, width);
  BOOST_OUTCOME_TRY(other_heights, gather_duplicates(run, tiles.tiles, duplicates, rows ? &*rows : nullptr));
  if (height_offset(run.dimension, run.schema)) manifest.other_heights = other_heights;
  // A result is complete once it has its manifest, so the report is written before.
  const auto report = [&]() -> Status {
    add_duplicates(summary, manifest);
    summary.digest = manifest.digest ? digest_text(*manifest.digest) : "";
    summary.seconds = seconds_of_phases(routed_s - began_s, tiles.wall, elapsed_s() - ran_s);
    summary.total_s = elapsed_s();
    summary.peak_memory_bytes = peak_memory();
    add_figures(summary, manifest);
    auto spans = with_threads_from_0(progress.spans());
    spans.push_back({Phase::routing, {}, 0, began_s, routed_s});
    spans.push_back({Phase::finishing, {}, 0, ran_s, elapsed_s()});
    BOOST_OUTCOME_TRYV(
        write_html_report(report_file(folder.path()), report_of(summary, manifest, tiles, std::move(spans))));
    return folder.check_claim();
  };
  BOOST_OUTCOME_TRYV(folder.check_claim());
  BOOST_OUTCOME_TRYV(finish_store(folder.path(), manifest, duplicates, report, rows ? &*rows : nullptr));
  BOOST_OUTCOME_TRYV(folder.finish());
  progress.phase = Phase::done;
  return summary;
}

// Opens the cloud and claims the folder. Inputs are unpacked where the result goes, as there is room for them.
Result<Cloud> open_in(ResultFolder& folder, JobOptions& options, const OpenCloud& open, const std::stop_token& stop) {
  std::error_code ignored;
  auto place = std::filesystem::absolute(folder.path(), ignored).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();  // "out/"
  BOOST_OUTCOME_TRY(stands, is_folder(place));
  options.cloud.spool_folder = stands ? place : place.parent_path();
  BOOST_OUTCOME_TRY(cloud, open(options, stop));
  BOOST_OUTCOME_TRYV(folder.claim());
  BOOST_OUTCOME_TRYV(folder.discard_runs());
  return std::move(cloud);
}

Result<std::optional<JobSummary>> run(Engine& engine, JobOptions options, const OpenCloud& open, ResultFolder& folder,
                                      Progress& progress, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(cloud, open_in(folder, options, open, stop));
  if (folder.resuming() && folder.state() == FolderState::finished) {
    remove_side_files(folder.path());
    BOOST_OUTCOME_TRY(run_is_left, folder.has_run());
    if (!run_is_left) {
      BOOST_OUTCOME_TRYV(check_finished(cloud, folder));
      BOOST_OUTCOME_TRYV(folder.finish());  // what is left of a run folder that was being removed
      return std::nullopt;
    }
    // The earlier job was stopped between its last two steps: the result is complete, and only the run folder is left.
    BOOST_OUTCOME_TRY(run, open_run(folder.run()));
    BOOST_OUTCOME_TRYV(check_same_job(run, cloud, options_key(options), folder));
    BOOST_OUTCOME_TRYV(folder.finish());
    return std::nullopt;
  }
  options.lock_file = folder.lock_file();
  auto summary = make_result(engine, options, std::move(cloud), folder, progress, stop);
  if (summary) return std::move(summary).value();
  BOOST_OUTCOME_TRYV(folder.check_claim());  // if another process has the folder by now, that is the error to report
  return summary.error();
}

Status give_tiles(Engine& engine, JobOptions options, const OpenCloud& open, const MakeTaker& make,
                  ResultFolder& folder, Progress& progress, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(cloud, open_in(folder, options, open, stop));
  options.lock_file = folder.lock_file();
  options.store = StoreAs::cells;
  BOOST_OUTCOME_TRY(run, routed_run(engine, options, cloud, folder, progress, stop));
  progress.map.begin(layout_of(run.partition, run.bounds), run.tile_points);
  cloud = {};
  BOOST_OUTCOME_TRY(taker, make(manifest_of(options, run, {})));
  options.taker = taker;
  BOOST_OUTCOME_TRYV(engine.run(run, folder.path(), options, progress, stop));
  progress.phase = Phase::done;
  return success();
}

// Runs a job, and returns error memory when the system has no more memory.
template <class Job>
auto with_memory(const Job& job) -> decltype(job()) {
  try {
    return job();
  } catch (const std::bad_alloc&) {
    return worded([] { return error(Errc::memory, "the system has no more memory to give"); });
  }
}

}  // namespace

Status run_tiles(Engine& engine, JobOptions options, const OpenCloud& open, const MakeTaker& make, ResultFolder& folder,
                 Progress& progress, const std::stop_token& stop) {
  return with_memory([&] {
    if (options.log) progress.log = options.log;
    return give_tiles(engine, std::move(options), open, make, folder, progress, stop);
  });
}

Result<std::optional<JobSummary>> run_job(Engine& engine, JobOptions options, const OpenCloud& open,
                                          ResultFolder& folder, Progress& progress, const std::stop_token& stop) {
  return with_memory([&] {
    if (options.log) progress.log = options.log;
    return run(engine, std::move(options), open, folder, progress, stop);
  });
}

}  // namespace tessera

#include "src/job/job.h"

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "src/job/inputs.h"
#include "src/job/job_report.h"
#include "src/job/machine.h"
#include "src/report/human.h"

namespace tessera {
namespace {

// A resumed run must be the same job on the same files, or its tiles would not fit together.
Status check_same_job(const RoutedRun& run, const Cloud& cloud, const std::string& key, const ResultFolder& folder) {
  const auto refuse = [&](const std::string& reason) {
    return error(Errc::usage, folder.path().string() + ": cannot be resumed: " + reason);
  };
  if (run.options_key != key) return refuse("the unfinished run was started with other options");
  if (run.inputs.size() != cloud.files().size()) return refuse("the unfinished run was started with other input files");
  for (std::size_t i = 0; i < run.inputs.size(); ++i) {
    const auto& then = run.inputs[i];
    const auto& now = cloud.files()[i];
    if (then.path != now.path.string()) return refuse("the unfinished run was started with other input files");
    if (then.bytes != now.bytes || then.modified_ns != now.modified_ns) {
      return refuse(then.path + " has changed since the run was started");
    }
  }
  return success();
}

// The routed points: those of the run that is resumed, or of a new one.
Result<RoutedRun> routed_run(const JobOptions& options, const Cloud& cloud, ResultFolder& folder, Progress& progress,
                             const std::stop_token& stop) {
  const auto key = options_key(options);
  if (folder.resuming()) {
    BOOST_OUTCOME_TRY(run, open_run(folder.run()));
    BOOST_OUTCOME_TRYV(check_same_job(run, cloud, key, folder));
    return std::move(run);
  }
  BOOST_OUTCOME_TRY(limit, tile_limit(options, cloud));
  progress.phase = Phase::routing;
  const RouteOptions route_options{.kind = options.partition,
                                   .max_points_per_tile = limit,
                                   .tiles = options.tiles,
                                   .memory_bytes = options.memory_bytes,
                                   .options_key = key};
  BOOST_OUTCOME_TRY(routed, route(cloud, folder.new_run(), route_options, progress, stop));
  BOOST_OUTCOME_TRYV(folder.accept_new_run());
  routed.folder = folder.run();
  return std::move(routed);
}

// Threads are numbered as they first work for any job of this process.
std::vector<Span> with_threads_from_0(std::vector<Span> spans) {
  std::map<std::uint32_t, std::uint32_t> numbers;
  for (const Span& span : spans) numbers[span.thread] = 0;
  for (std::uint32_t next = 0; auto& [thread, number] : numbers) number = next++;
  for (Span& span : spans) span.thread = numbers[span.thread];
  return spans;
}

Result<JobSummary> make_result(const JobOptions& options, Cloud cloud, ResultFolder& folder, Progress& progress,
                               const std::stop_token& stop) {
  const auto elapsed_s = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - progress.started).count();
  };
  const double began_s = elapsed_s();
  BOOST_OUTCOME_TRY(run, routed_run(options, cloud, folder, progress, stop));
  cloud = {};  // with what was unpacked for it: tiles need that disk
  const double routed_s = elapsed_s();
  if (options.log) {
    options.log("routed " + grouped(run.counts.read) + " points into " + std::to_string(run.partition.tiles()) +
                " tiles");
  }

  const RunOptions run_options{.threads = options.threads,
                               .memory_bytes = options.memory_bytes,
                               .kernel = options.kernel,
                               .keep = options.keep,
                               .store = {.neighbors = options.neighbors, .schema = run.schema}};
  BOOST_OUTCOME_TRY(tiles, run_tiles(run, folder.path(), run_options, progress, stop));
  const double ran_s = elapsed_s();

  progress.phase = Phase::finishing;
  auto manifest = manifest_of(options, run, tiles);
  auto summary = summary_of(options, folder.path(), manifest, tiles);
  manifest.seconds = {{"routing", routed_s - began_s},
                      {"triangulating", tiles.triangulate_s},
                      {"splaying", tiles.splay_s},
                      {"collecting", tiles.collect_s}};
  manifest.figures = {{"threads", options.threads},
                      {"messages", static_cast<double>(tiles.batches)},
                      {"points_sent", static_cast<double>(tiles.points_sent)},
                      {"points_received", static_cast<double>(tiles.points_received)},
                      {"points_inserted", static_cast<double>(tiles.points_inserted)},
                      {"points_kept", static_cast<double>(tiles.points_kept)},
                      {"rounds", static_cast<double>(tiles.rounds)},
                      {"sleeps", static_cast<double>(tiles.sleeps)},
                      {"triangulating_cpu_s", tiles.triangulate_cpu_s},
                      {"splaying_cpu_s", tiles.splay_cpu_s},
                      {"collecting_cpu_s", tiles.collect_cpu_s},
                      {"peak_memory_bytes", static_cast<double>(peak_memory())}};
  BOOST_OUTCOME_TRYV(finish_store(folder.path(), manifest, tiles.duplicates));

  summary.seconds = {{"routing", routed_s - began_s},
                     {"triangulating", tiles.triangulate_s},
                     {"splaying", tiles.splay_s},
                     {"collecting", tiles.collect_s},
                     {"finishing", elapsed_s() - ran_s}};
  summary.total_s = elapsed_s();
  summary.peak_memory_bytes = peak_memory();
  auto spans = with_threads_from_0(progress.spans());
  spans.push_back({Phase::routing, 0, 0, began_s, routed_s});
  spans.push_back({Phase::finishing, 0, 0, ran_s, elapsed_s()});
  // The run folder goes first: the report is small, and may find the space that it frees.
  BOOST_OUTCOME_TRYV(folder.finish());
  BOOST_OUTCOME_TRYV(
      write_html_report(folder.path() / "report.html", report_of(summary, manifest, tiles, std::move(spans))));
  progress.phase = Phase::done;
  return summary;
}

}  // namespace

Result<std::optional<JobSummary>> run_job(JobOptions options, const OpenCloud& open, ResultFolder& folder,
                                          Progress& progress, const std::stop_token& stop) {
  // Where the result goes there is room for what has to be unpacked.
  std::error_code ignored;
  auto place = std::filesystem::absolute(folder.path(), ignored).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();  // "out/"
  options.cloud.spool_folder = std::filesystem::is_directory(place, ignored) ? place : place.parent_path();
  BOOST_OUTCOME_TRY(cloud, open(options, stop));
  BOOST_OUTCOME_TRYV(folder.claim());
  if (folder.resuming() && folder.state() == FolderState::finished) {
    // Stopped between its last two steps: the result is whole, only the run folder is left.
    BOOST_OUTCOME_TRY(run, open_run(folder.run()));
    BOOST_OUTCOME_TRYV(check_same_job(run, cloud, options_key(options), folder));
    BOOST_OUTCOME_TRYV(folder.finish());
    return std::nullopt;
  }
  BOOST_OUTCOME_TRYV(folder.discard_runs());
  BOOST_OUTCOME_TRY(summary, make_result(options, std::move(cloud), folder, progress, stop));
  return std::move(summary);
}

}  // namespace tessera

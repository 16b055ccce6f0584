// tessera triangulate: point files in, result folder out.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "actors/local_run.h"
#include "src/apps/command.h"
#include "src/apps/interrupt.h"
#include "src/apps/job.h"
#include "src/apps/log.h"
#include "src/apps/machine.h"
#include "src/apps/result_folder.h"
#include "src/apps/triangulate_options.h"
#include "src/apps/version.h"
#include "src/report/html_report.h"
#include "src/report/human.h"
#include "src/report/progress_display.h"
#include "src/report/summary.h"
#include "src/store/tile_store.h"
#include "src/tiling/routed_run.h"

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
Result<RoutedRun> routed_run(const TriangulateOptions& options, const Cloud& cloud, ResultFolder& folder,
                             Progress& progress, const std::stop_token& stop) {
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

Manifest manifest_of(const TriangulateOptions& options, const RoutedRun& run, const RunSummary& tiles,
                     const std::vector<std::string>& command_line) {
  Manifest manifest;
  manifest.software_version = version();
  manifest.command = command_line;
  for (const auto& input : run.inputs) manifest.inputs.push_back({input.path, input.bytes, input.modified_ns});
  manifest.dimension = run.dimension;
  manifest.crs = run.crs;
  manifest.partition_kind = name_of(run.partition.kind());
  manifest.boxes = run.partition.boxes();
  manifest.bounds = run.bounds;
  manifest.neighbors = options.neighbors;
  manifest.schema = run.schema;
  manifest.tiles = tiles.tiles;
  manifest.points_read = run.counts.read;
  manifest.invalid = run.counts.invalid;
  manifest.filtered = run.counts.filtered;
  manifest.duplicates = tiles.duplicates.size();
  manifest.vertices = tiles.vertices;
  manifest.cells = tiles.cells;
  return manifest;
}

JobSummary summary_of(const TriangulateOptions& options, const Manifest& manifest, const RunSummary& tiles) {
  JobSummary summary;
  summary.out = options.out.string();
  summary.dimension = manifest.dimension;
  summary.points_read = manifest.points_read;
  summary.invalid = manifest.invalid;
  summary.filtered = manifest.filtered;
  summary.duplicates = manifest.duplicates;
  summary.vertices = manifest.vertices;
  summary.cells = manifest.cells;
  summary.tiles = manifest.tiles.size();
  summary.messages = tiles.batches;
  summary.points_sent = tiles.points_sent;
  summary.points_received = tiles.points_received;
  summary.points_inserted = tiles.points_inserted;
  summary.points_kept = tiles.points_kept;
  summary.rounds = tiles.rounds;
  summary.waves = tiles.waves;
  summary.sleeps = tiles.sleeps;
  summary.threads = options.threads;
  summary.memory_budget_bytes = options.memory_bytes;
  for (const auto& tile : manifest.tiles) summary.result_bytes += tile.bytes;
  return summary;
}

ReportData report_of(const JobSummary& summary, const Manifest& manifest, const RunSummary& tiles,
                     std::vector<Span> spans) {
  ReportData report;
  report.summary = summary;
  report.version = manifest.software_version;
  report.command = manifest.command;
  for (const auto& input : manifest.inputs) report.inputs.push_back(input.path);
  report.crs = manifest.crs;
  report.partition_kind = manifest.partition_kind;
  report.boxes_disjoint = manifest.partition_kind != name_of(PartitionKind::random);
  report.bounds = manifest.bounds;
  for (const auto& entry : manifest.tiles) {
    TileFigures figures;
    figures.tile = entry.tile;
    figures.points = entry.own_points;
    figures.cells = entry.main_cells;
    figures.bytes = entry.bytes;
    if (entry.tile < manifest.boxes.size()) figures.box = manifest.boxes[entry.tile];
    if (entry.tile < tiles.tile_seconds.size()) figures.seconds = tiles.tile_seconds[entry.tile];
    report.tiles.push_back(figures);
  }
  report.spans = std::move(spans);
  return report;
}

ProgressStyle progress_style(const OutputOptions& output) {
  if (output.quiet) return ProgressStyle::none;
  if (output.json) return ProgressStyle::json;
  // Log lines would tear the panel apart.
  return isatty(STDERR_FILENO) != 0 && !output.verbose ? ProgressStyle::terminal : ProgressStyle::lines;
}

Result<JobSummary> make_result(const TriangulateOptions& options, const Cloud& cloud, ResultFolder& folder,
                               const std::vector<std::string>& command_line, ProgressDisplay& display,
                               Progress& progress, const std::stop_token& stop) {
  const double began_s = display.elapsed_s();
  BOOST_OUTCOME_TRY(run, routed_run(options, cloud, folder, progress, stop));
  const double routed_s = display.elapsed_s();
  log_debug("routed " + grouped(run.counts.read) + " points into " + std::to_string(run.partition.tiles()) + " tiles");

  const RunOptions run_options{.threads = options.threads,
                               .memory_bytes = options.memory_bytes,
                               .kernel = options.kernel,
                               .store = {.neighbors = options.neighbors, .schema = run.schema}};
  BOOST_OUTCOME_TRY(tiles, run_tiles(run, folder.path(), run_options, progress, stop));
  const double ran_s = display.elapsed_s();

  progress.phase = Phase::finishing;
  auto manifest = manifest_of(options, run, tiles, command_line);
  auto summary = summary_of(options, manifest, tiles);
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
                     {"finishing", display.elapsed_s() - ran_s}};
  summary.total_s = display.elapsed_s();
  summary.peak_memory_bytes = peak_memory();
  auto spans = progress.spans();
  spans.push_back({Phase::routing, 0, 0, began_s, routed_s});
  spans.push_back({Phase::finishing, 0, 0, ran_s, display.elapsed_s()});
  // The run folder goes first: the report is small, and may find the space that it frees.
  BOOST_OUTCOME_TRYV(folder.finish());
  BOOST_OUTCOME_TRYV(
      write_html_report(folder.path() / "report.html", report_of(summary, manifest, tiles, std::move(spans))));
  progress.phase = Phase::done;
  return summary;
}

Status run_triangulate(TriangulateOptions options, const std::vector<std::string>& command_line) {
  const Interrupt interrupt;
  Progress progress;
  BOOST_OUTCOME_TRY(folder, ResultFolder::inspect(options.out, options.resume, options.overwrite));
  ProgressDisplay display(progress, progress_style(options.output), options.output.json ? stdout : stderr);
  BOOST_OUTCOME_TRY(cloud, open_cloud(options, interrupt.token()));
  if (options.resume && folder.state() == FolderState::finished) {
    // Stopped between its last two steps: the result is whole, only the run folder is left.
    BOOST_OUTCOME_TRYV(folder.claim());
    BOOST_OUTCOME_TRY(run, open_run(folder.run()));
    BOOST_OUTCOME_TRYV(check_same_job(run, cloud, options_key(options), folder));
    return folder.finish();
  }
  auto summary = [&]() -> Result<JobSummary> {
    BOOST_OUTCOME_TRYV(folder.claim());
    BOOST_OUTCOME_TRYV(folder.discard_runs());
    return make_result(options, cloud, folder, command_line, display, progress, interrupt.token());
  }();
  display.stop();
  if (!summary) {
    if (summary.error().code != Errc::interrupted) {
      folder.abandon();
      return summary.error();
    }
    if (reads_standard_input(options)) {
      folder.abandon();
      return error(Errc::interrupted, "interrupted; standard input cannot be read again, so nothing is kept");
    }
    const bool resumable = folder.interrupted();
    return error(Errc::interrupted, resumable ? "interrupted; the same command with --resume continues"
                                              : "interrupted while reading the input; nothing is kept");
  }
  if (!options.output.quiet) {
    std::fputs(
        options.output.json ? (summary_json(summary.value()) + "\n").c_str() : summary_text(summary.value()).c_str(),
        stdout);
  }
  return success();
}

}  // namespace

Command add_triangulate(CLI::App& root) {
  auto command =
      new_command(root, "triangulate", "Triangulates point files into a result folder",
                  "  tessera triangulate block/*.las -o out/\n"
                  "  tessera triangulate a.las b.ply -o out/ --memory 4G --threads 8\n"
                  "  tessera triangulate block/ --recursive -o out/      (the point files in a folder)\n"
                  "  zcat scan.xyz.gz | tessera triangulate - -o out/\n"
                  "  tessera triangulate city.copc.laz -o out/ --crop 885000,629000,885200,629200 --resolution 0.5\n"
                  "  tessera triangulate scan.las -o ground/ --dim 2 --class 2,9 --attributes intensity\n"
                  "  tessera triangulate huge.las -o out/ --resume      (after Ctrl-C or a crash)");
  add_triangulate_options(command);
  auto inputs = std::make_shared<std::vector<std::string>>();
  command.app
      ->add_option("inputs", *inputs,
                   "LAS, LAZ, COPC, PLY, XYZ/CSV or NPY files, also as .gz or .zst; folders of them; patterns of "
                   "their names; - for standard input")
      ->type_name("FILE");
  command.run = [settings = command.settings.get(), inputs](const std::vector<std::string>& command_line) -> Status {
    BOOST_OUTCOME_TRY(options, read_triangulate_options(*settings, *inputs));
    if (options.output.verbose) log_everything();
    return run_triangulate(std::move(options), command_line);
  };
  return command;
}

}  // namespace tessera

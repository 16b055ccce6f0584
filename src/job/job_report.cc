#include "src/job/job_report.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "src/base/crs/crs.h"
#include "src/base/phases.h"
#include "src/job/version.h"
#include "src/result/store/digest.h"
#include "src/result/store/period.h"

namespace tessera {

Manifest manifest_of(const JobOptions& options, const RoutedCloud& run, const RunSummary& tiles) {
  Manifest manifest;
  manifest.software_version = version();
  manifest.command = options.command;
  bool known = true;  // how many source indices the inputs before took
  std::uint64_t first = 0;
  for (const auto& input : run.inputs) {
    manifest.inputs.push_back({input.path, input.bytes, input.modified_ns});
    known &= input.points.has_value();
    if (!known) continue;
    manifest.inputs.back().ids = {first, *input.points};
    first += *input.points;
  }
  manifest.dimension = run.dimension;
  manifest.crs = run.crs;
  manifest.unit = run.unit;
  manifest.partition_kind = name_of(run.partition.kind());
  manifest.boxes = run.partition.boxes();
  manifest.partition = run.partition.to_json();
  if (run.partition.period().any()) manifest.format_version = periodic_format;
  manifest.bounds = run.bounds;
  manifest.neighbors = options.neighbors;
  manifest.schema = run.schema;
  manifest.tiles = tiles.tiles;
  manifest.points_read = run.counts.read;
  manifest.invalid = run.counts.invalid;
  manifest.filtered = run.counts.filtered;
  manifest.keep = run.keep;
  manifest.vertices = tiles.vertices;
  manifest.cells = tiles.cells;
  return manifest;
}

JobSummary summary_of(const JobOptions& options, const std::filesystem::path& out, const Manifest& manifest,
                      const RunSummary& tiles) {
  JobSummary summary;
  summary.out = options.place.empty() ? out.string() : options.place;
  summary.dimension = manifest.dimension;
  summary.points_read = manifest.points_read;
  summary.invalid = manifest.invalid;
  summary.filtered = manifest.filtered;
  summary.vertices = manifest.vertices;
  summary.cells = manifest.cells;
  summary.tiles = manifest.tiles.size();
  summary.exchange = tiles.exchange;
  summary.threads = options.threads;
  summary.memory_budget_bytes = tiles.memory_bytes > 0 ? tiles.memory_bytes : options.memory_bytes;
  for (const auto& tile : manifest.tiles) summary.result_bytes += tile.bytes;
  return summary;
}

void add_duplicates(JobSummary& summary, const Manifest& manifest) {
  summary.duplicates = manifest.duplicates;
  summary.other_heights = manifest.other_heights;
  summary.keep = manifest.keep;
}

void add_figures(const JobSummary& summary, Manifest& manifest) {
  manifest.seconds = {summary.seconds.begin(), summary.seconds.end()};
  const ExchangeFigures& e = summary.exchange;
  const auto number = [](std::uint64_t n) { return static_cast<double>(n); };
  manifest.figures = {{"threads", number(summary.threads)},
                      {"messages", number(e.updates)},
                      {"points_sent", number(e.points.sent)},
                      {"points_received", number(e.points.received)},
                      {"points_inserted", number(e.points.inserted)},
                      {"points_kept", number(e.points.useful)},
                      {"rounds", number(e.hops)},
                      {"most_received", number(e.most_received)},
                      {"sleeps", number(e.sleeps)},
                      {"nodes", number(e.nodes)},
                      {"nodes_lost", number(e.nodes_lost)},
                      {"tiles_again", number(e.tiles_again)},
                      {"bytes_between", number(e.bytes_between)},
                      {"credit_waits", number(e.credit_waits)},
                      {"memory_budget_bytes", number(summary.memory_budget_bytes)},
                      {"peak_memory_bytes", number(summary.peak_memory_bytes)}};
  for (const PhaseRow& row : phase_table) {
    if (row.program == ProgramKind::delaunay) manifest.figures[std::string(row.name) + "_cpu_s"] = e.work.of(row.step);
  }
}

JobSummary summary_of(const Manifest& manifest, const std::filesystem::path& out) {
  const auto figure = [&](const char* name) {
    const auto found = manifest.figures.find(name);
    return found == manifest.figures.end() || !(found->second >= 0) ? 0 : static_cast<std::uint64_t>(found->second);
  };
  RunSummary tiles;
  ExchangeFigures& e = tiles.exchange;
  e.updates = figure("messages");
  e.points.sent = figure("points_sent");
  e.points.received = figure("points_received");
  e.points.inserted = figure("points_inserted");
  e.points.useful = figure("points_kept");
  e.hops = figure("rounds");
  e.most_received = figure("most_received");
  e.sleeps = figure("sleeps");
  e.nodes = figure("nodes");
  e.nodes_lost = figure("nodes_lost");
  e.tiles_again = figure("tiles_again");
  e.bytes_between = figure("bytes_between");
  e.credit_waits = figure("credit_waits");
  JobOptions options;
  options.threads = static_cast<std::uint32_t>(figure("threads"));
  auto summary = summary_of(options, out, manifest, tiles);
  add_duplicates(summary, manifest);
  summary.memory_budget_bytes = figure("memory_budget_bytes");
  summary.peak_memory_bytes = figure("peak_memory_bytes");
  if (manifest.digest) summary.digest = digest_text(*manifest.digest);
  for (const PhaseRow& row : phase_table) {
    const auto found = manifest.seconds.find(row.name);
    if (found == manifest.seconds.end()) continue;
    summary.seconds.emplace_back(*found);
    summary.total_s += found->second;
  }
  return summary;
}

ReportData report_of(const JobSummary& summary, const Manifest& manifest, const RunSummary& tiles,
                     std::vector<PhaseSpan> spans) {
  ReportData report;
  report.summary = summary;
  report.version = manifest.software_version;
  report.command = manifest.command;
  for (const auto& input : manifest.inputs) report.inputs.push_back(input.path);
  report.crs_title = crs_title(manifest.crs);
  report.finished = std::chrono::system_clock::now();
  report.partition_kind = manifest.partition_kind;
  report.boxes_disjoint = manifest.partition_kind != name_of(PartitionKind::random);
  report.bounds = manifest.bounds;
  report.period = period_of(manifest);
  if (const auto heights = heights_of(manifest); heights && manifest.dimension == 2) {
    report.heights = {heights->lo, heights->hi};
  }
  for (std::size_t i = 0; i < manifest.tiles.size(); ++i) {
    const TileEntry& entry = manifest.tiles[i];
    TileFigures figures;
    figures.tile = entry.tile;
    figures.points = entry.own_points;
    figures.cells = entry.main_cells;
    figures.bytes = entry.bytes;
    if (entry.tile.value < manifest.boxes.size()) figures.box = manifest.boxes[entry.tile.value];
    figures.seconds = tiles.tile_seconds[i];
    report.tiles.push_back(figures);
  }
  report.spans = std::move(spans);
  return report;
}

}  // namespace tessera

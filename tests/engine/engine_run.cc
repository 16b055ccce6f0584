#include "tests/engine/engine_run.h"

#include <stop_token>
#include <utility>
#include <vector>

#include "src/delaunay/duplicates.h"
#include "src/input/cloud/cloud.h"
#include "src/result/store/period.h"

namespace tessera::testing {

namespace fs = std::filesystem;

std::string text_of(const EngineOptions& o) {
  const char* keep = o.keep == TileRetention::whole     ? " whole"
                     : o.keep == TileRetention::reduced ? " reduced"
                                                        : " by_budget";
  return std::to_string(o.dimension) + "D " + name_of(o.partition) + " tiles " + std::to_string(o.tiles) + " threads " +
         std::to_string(o.threads) + keep + " memory " + std::to_string(o.memory_bytes) +
         (o.skip_invalid ? " skip_invalid" : "") + (o.store == StoreAs::points ? " points" : "");
}

Result<EngineRun> run_engine(const fs::path& input, const fs::path& out, const EngineOptions& options) {
  Progress progress;
  CloudOptions cloud_options;
  cloud_options.dimension = options.dimension;
  cloud_options.skip_invalid = options.skip_invalid;
  cloud_options.periodic = options.periodic;
  BOOST_OUTCOME_TRY(cloud, Cloud::open({input.string()}, cloud_options));
  const fs::path run_folder = out / ".run";
  const RouteOptions route_options{.kind = options.partition, .tiles = options.tiles};
  BOOST_OUTCOME_TRY(routed, route(cloud, run_folder, route_options, progress, std::stop_token{}));

  EngineRun run;
  run.routed = std::move(routed);
  Engine engine(options.threads, options.memory_bytes);
  BOOST_OUTCOME_TRY(summary, engine.run(run.routed, out, options, progress, std::stop_token{}));
  run.summary = std::move(summary);

  Manifest& manifest = run.manifest;
  manifest.software_version = "test";
  for (const auto& file : run.routed.inputs) manifest.inputs.push_back({file.path, file.bytes, file.modified_ns});
  manifest.dimension = options.dimension;
  manifest.partition_kind = name_of(options.partition);
  manifest.boxes = run.routed.partition.boxes();
  manifest.partition = run.routed.partition.to_json();
  if (run.routed.partition.period().any()) manifest.format_version = periodic_format;
  manifest.bounds = run.routed.bounds;
  manifest.neighbors = options.neighbors;
  manifest.schema = run.routed.schema;
  manifest.tiles = run.summary.tiles;
  manifest.points_read = run.routed.counts.read;
  manifest.invalid = run.routed.counts.invalid;
  manifest.filtered = run.routed.counts.filtered;
  manifest.vertices = run.summary.vertices;
  manifest.cells = run.summary.cells;
  DuplicateSort duplicates(run_folder, 1 << 20);
  BOOST_OUTCOME_TRYV(gather_duplicates(run.routed, run.summary.tiles, duplicates));
  BOOST_OUTCOME_TRYV(finish_store(out, manifest, duplicates));
  fs::remove_all(run_folder);
  return run;
}

}  // namespace tessera::testing

#include "src/job/region_job.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "src/base/files/whole_file.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/job/machine.h"
#include "src/job/report/human.h"
#include "src/job/version.h"
#include "src/tiling/kept_points.h"
#include "src/tiling/partition.h"

namespace tessera {
namespace {

Manifest manifest_of(const RegionCloud& cloud, const RegionJobOptions& options, const RegionCells& cells,
                     const TileEntry& tile) {
  const auto number = [](std::uint64_t n) { return static_cast<double>(n); };
  const RegionFigures& figures = cells.figures;
  const Partition whole;
  Manifest manifest;
  manifest.software_version = version();
  manifest.command = options.command;
  manifest.inputs = cloud.inputs;
  manifest.dimension = cloud.dimension;
  manifest.crs = cloud.crs;
  manifest.unit = cloud.unit;
  manifest.partition_kind = name_of(whole.kind());
  manifest.boxes = whole.boxes();
  // The partition that is all of space has no dimension of its own.
  manifest.partition = json_text(nlohmann::json{{"kind", manifest.partition_kind},
                                                {"dimension", cloud.dimension},
                                                {"tiles", whole.tiles()},
                                                {"splits", nlohmann::json::array()}});
  for (const Point& p : cells.mesh.points) manifest.bounds.add(p);
  // The format knows only boxes. Of a polygon's box the result does not have all cells, and those that it has are
  // final.
  manifest.region = {options.box, cells.complete && !options.shape};
  manifest.neighbors = options.neighbors;
  manifest.keep = options.cloud.keep;
  manifest.schema = cloud.schema;
  manifest.tiles = {tile};
  manifest.points_read = cloud.points;
  manifest.vertices = tile.own_points;
  manifest.cells = tile.main_cells;
  manifest.seconds = {{"region", figures.seconds}};
  manifest.figures = {{"units", number(figures.units)},
                      {"units_read", number(figures.units_read)},
                      {"points_read", number(figures.points_read)},
                      {"input_bytes", number(figures.bytes)},
                      {"read_bytes", number(figures.bytes_read)},
                      {"rounds", number(figures.rounds)},
                      {"peak_memory_bytes", number(peak_memory())}};
  return manifest;
}

Status store(const RegionCloud& cloud, const RegionJobOptions& options, const RegionCells& cells, ResultFolder& folder,
             const std::stop_token& stop) {
  BOOST_OUTCOME_TRYV(folder.discard_runs());
  BOOST_OUTCOME_TRYV(make_directories(folder.new_run()));  // an old result is removed in the same way as before a run
  BOOST_OUTCOME_TRYV(folder.accept_new_run());
  const StoreOptions how{
      .neighbors = options.neighbors, .schema = cloud.schema, .lock_file = folder.lock_file(), .stop = stop};
  const auto written = [&]() -> Result<TileEntry> {
    try {
      return write_tile(folder.path(), TileId{0}, cells.mesh, cells.rows, how);
    } catch (const Stopped&) {
      return error(Errc::interrupted, "interrupted; nothing is kept");
    }
  };
  BOOST_OUTCOME_TRY(tile, written());
  Manifest manifest = manifest_of(cloud, options, cells, tile);
  BOOST_OUTCOME_TRYV(folder.check_claim());
  BOOST_OUTCOME_TRYV(finish_store(folder.path(), manifest, std::span<const DuplicatePair>()));
  return folder.finish();
}

}  // namespace

Result<RegionCloud> open_regions(const std::vector<std::string>& inputs, const RegionJobOptions& options,
                                 const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(cloud, Cloud::open(inputs, options.cloud, stop));
  RegionCloud opened;
  for (const auto& file : cloud.files()) opened.inputs.push_back({file.path.string(), file.bytes, file.modified_ns});
  opened.schema = cloud.schema();
  opened.crs = cloud.crs();
  opened.unit = cloud.unit();
  opened.warnings = cloud.warnings();
  opened.dimension = cloud.options().dimension;
  if (opened.dimension == 2 && (std::isfinite(options.box.lo.z) || std::isfinite(options.box.hi.z)))
    return error(Errc::usage, option("bbox") + ": the cloud has no heights; give xmin,ymin,xmax,ymax");
  BOOST_OUTCOME_TRY(units, CloudUnits::open(std::move(cloud), options.scan_files, stop));
  opened.points = units->points();
  EqualPoints equal{.keep = options.cloud.keep};
  if (is_by_height(equal.keep)) equal.height_at = height_offset(opened.dimension, opened.schema);
  opened.regions = std::make_unique<Regions>(std::move(units), opened.dimension, row_bytes(opened.schema), equal);
  return opened;
}

Result<RegionSummary> write_region(RegionCloud& cloud, const RegionJobOptions& options, ResultFolder& folder,
                                   const std::stop_token& stop) {
  if (options.check_place) {
    BOOST_OUTCOME_TRYV(options.check_place(cloud.crs, cloud.regions->bounds()));
  }
  BOOST_OUTCOME_TRYV(folder.claim());
  BOOST_OUTCOME_TRY(cells, cloud.regions->ask(options.box, options.limits, stop, options.shape));
  if (cells.mesh.cell_ghost.empty())
    return error(Errc::usage, options.shape ? option("polygon") + ": no cell of the triangulation meets it"
                                            : option("bbox") + ": no cell of the triangulation meets the box");
  RegionSummary summary{.out = folder.path().string(),
                        .dimension = cloud.dimension,
                        .vertices = cells.mesh.points.size(),
                        .cells = cells.mesh.cell_ghost.size(),
                        .final = static_cast<std::uint64_t>(std::count(cells.final.begin(), cells.final.end(), 1)),
                        .complete = cells.complete,
                        .needed = cells.needed,
                        .figures = cells.figures,
                        .warnings = cloud.warnings};
  if (!cells.complete || options.shape) cells.mesh.cell_final.assign(cells.final.begin(), cells.final.end());
  BOOST_OUTCOME_TRYV(store(cloud, options, cells, folder, stop));
  return summary;
}

std::string region_text(const RegionSummary& summary) {
  const RegionFigures& f = summary.figures;
  std::string text = summary.out + ": " + grouped(summary.vertices) + " vertices, " + grouped(summary.cells) +
                     (summary.dimension == 3 ? " tetrahedra" : " triangles");
  if (!summary.complete) text += ", " + grouped(summary.final) + " of them final";
  text += "\nread " + grouped(f.points_read) + " of " + grouped(f.points) + " points, " + human_bytes(f.bytes_read) +
          " of " + human_bytes(f.bytes) + ", " + grouped(f.units_read) + " of " + grouped(f.units) + " units, in " +
          grouped(f.rounds) + (f.rounds == 1 ? " round, " : " rounds, ") + human_seconds(f.seconds) + "\n";
  return text;
}

std::string region_json(const RegionSummary& summary) {
  const RegionFigures& f = summary.figures;
  const nlohmann::ordered_json object{
      {"event", "finished"},          {"output", summary.out},      {"dimension", summary.dimension},
      {"vertices", summary.vertices}, {"cells", summary.cells},     {"final", summary.final},
      {"complete", summary.complete}, {"points", f.points},         {"points_read", f.points_read},
      {"input_bytes", f.bytes},       {"read_bytes", f.bytes_read}, {"units", f.units},
      {"units_read", f.units_read},   {"rounds", f.rounds},         {"seconds", f.seconds},
      {"warnings", summary.warnings}};
  return json_text(object);
}

}  // namespace tessera

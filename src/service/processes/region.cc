// The process region.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "src/base/attribute.h"
#include "src/base/files/folder.h"
#include "src/base/json/json_text.h"
#include "src/job/estimate.h"
#include "src/job/open_cloud.h"
#include "src/job/region_job.h"
#include "src/job/report/human.h"
#include "src/job/result_folder.h"
#include "src/service/json.h"
#include "src/service/problem.h"
#include "src/service/processes/convert.h"
#include "src/service/processes/costs.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/region_clouds.h"
#include "src/service/processes/rows.h"
#include "src/service/processes/workshop.h"
#include "src/tiling/budget/budget.h"

namespace tessera::service {
namespace {

// All inputs that identify a cloud, as text.
std::string words_of(const proto::RegionInputs& inputs) {
  const auto cloud = cloud_of(inputs);
  return (cloud ? to_json(cloud.value()) : "") + (inputs.scan_files() ? " scan_files" : "");
}

Result<RegionJobOptions> options_of(const Workshop& shop, const proto::RegionInputs& inputs) {
  BOOST_OUTCOME_TRY(options, region_options(inputs, shop.share));
  options.cloud.spool_folder = shop.data;
  options.cloud.spool_bytes_max = unpacked_max(shop.limits, shop.data);
  if (shop.limits.points > 0) options.limits.max_points = std::min(options.limits.max_points, shop.limits.points);
  return options;
}

Result<RegionSummary> write(const Workshop& shop, const JobWork& work, const std::vector<std::string>& files,
                            const RegionJobOptions& options, ResultFolder& folder) {
  BOOST_OUTCOME_TRY(lent, shop.clouds.lend(files, options, words_of(work.job.inputs().region()), work.ledger.token()));
  for (const auto& warning : lent.cloud.warnings) work.log("warning: " + warning);
  BOOST_OUTCOME_TRY(summary, write_region(lent.cloud, options, folder, work.ledger.token()));
  shop.clouds.give_back(std::move(lent));
  return summary;
}

// The outcome of a region that was published just before an earlier process ended, from its folder.
Result<std::string> outcome_of_stored(const Workshop& shop, const std::string& name) {
  BOOST_OUTCOME_TRY(manifest, shop.results.manifest(name));
  nlohmann::ordered_json told{{"event", "finished"},
                              {"output", name},
                              {"dimension", manifest->dimension},
                              {"vertices", manifest->vertices},
                              {"cells", manifest->cells}};
  for (const auto& [figure, number] : manifest->figures) told[figure] = number;
  return json_text(told) + "\n";
}

Reply<JobDone> run_region(const Workshop& shop, const JobWork& work) {
  const auto& job = work.job;
  auto options = options_of(shop, job.inputs().region());
  if (!options) return problem_of(options.error());
  options.value().command = ResultFolders::command_of(job);
  options.value().limits.progress = [&](std::uint64_t points, std::uint64_t needed) {
    work.progress.points_total = needed;
    work.progress.points_triangulated = points;
  };
  const auto path = shop.results.unfinished(job.id());
  const auto published = job.starts() > 1 ? shop.results.is_published(job.id(), job.triangulation()) : false;
  if (!published) return problem_of(published.error());
  if (published.value()) {
    auto told = outcome_of_stored(shop, job.triangulation());
    if (!told) return problem_of(told.error());
    return JobDone{std::move(told).value(), 0, {}};
  }
  auto files = shop.roots.files(list_of(job.inputs().region().inputs()), job.inputs().region().recursive());
  if (!files) return problem_of(files.error());
  // What an earlier attempt has left is not continued.
  auto folder = ResultFolder::inspect(path, false, true);
  if (!folder) return problem_of(folder.error());
  folder.value().lock_with(lock_of_unfinished(shop, work.ledger.token()));
  auto summary = write(shop, work, files.value(), options.value(), folder.value());
  if (!summary) {
    folder.value().abandon();
    return problem_of(summary.error());
  }
  summary.value().out = job.triangulation();
  if (!summary.value().complete) work.log("note: " + summary.value().needed);
  return JobDone{region_json(summary.value()) + "\n",
                 summary.value().figures.points_read,
                 {{"region", summary.value().figures.seconds}}};
}

// Estimates the cost of the points in boxes that meet the region; usually not many more are needed. `reason` is set
// when the job is not accepted, or when files must be read before anything is known. Error: as open_regions().
Result<proto::Estimate> estimate_boxes(const Workshop& shop, const proto::RegionInputs& inputs) {
  proto::Estimate estimate;
  BOOST_OUTCOME_TRY(options, options_of(shop, inputs));
  estimate.set_accepted(true);
  const auto found = shop.roots.files(list_of(inputs.inputs()), inputs.recursive());
  if (Ledger::reason_of_thread()) {
    estimate.set_reason("there are too many files to measure now; they are measured when the job runs");
    return estimate;
  }
  if (!found) return found.error();
  const auto& files = found.value();
  BOOST_OUTCOME_TRY(packed, any_packed(files));
  if (packed || options.scan_files) {
    estimate.set_reason("files that are compressed or scanned are measured only when the job runs");
    return estimate;
  }
  BOOST_OUTCOME_TRY(cloud, Cloud::open(files, options.cloud, Ledger::token_of_thread()));
  for (const auto& file : cloud.files()) {
    if (file.bounds) continue;
    estimate.set_reason("files without the bounds of their points are measured only when the job runs");
    return estimate;
  }
  BOOST_OUTCOME_TRY(lent, shop.clouds.lend(files, options, words_of(inputs), Ledger::token_of_thread()));
  const RegionCloud& regions = lent.cloud;
  std::uint64_t points = 0, units = 0;
  const Bounds box{options.box.lo, options.box.hi};
  for (const auto& unit : regions.regions->units().list()) {
    bool meets = true;
    for (int axis = 0; axis < regions.dimension; ++axis)
      meets = meets && unit.bounds.lo[axis] <= box.hi[axis] && box.lo[axis] <= unit.bounds.hi[axis];
    if (!meets) continue;
    points += unit.points;
    ++units;
  }
  const auto row = row_bytes(regions.schema);
  const auto cost = tessera::estimate(regions.dimension, KernelKind::flat, TileKind::cells, points,
                                      std::max<std::uint64_t>(points, 1), options.neighbors, row,
                                      {.memory_bytes = shop.share.memory_bytes, .threads = 1});
  estimate.set_points(points);
  estimate.set_cells(cost.cells);
  estimate.set_tiles(units > 0 ? 1 : 0);
  estimate.set_memory_bytes(budget::region_bytes(regions.dimension, points, row));
  estimate.set_result_bytes(cost.result_bytes);
  estimate.set_seconds(cost.seconds);
  shop.clouds.give_back(std::move(lent));
  const auto refuse = [&](const std::string& why) {
    estimate.set_accepted(false);
    estimate.set_reason(std::string(inputs.has_polygon() ? "polygon: the parts of the files that meet its box hold "
                                                         : "bbox: the parts of the files that meet it hold ") +
                        grouped(points) + " points, " + why);
  };
  if (inputs.partial()) return estimate;
  if (points > options.limits.max_points) {
    refuse("and at most " + grouped(options.limits.max_points) + " are allowed");
  } else if (estimate.memory_bytes() > options.limits.memory_bytes) {
    refuse("which need " + human_bytes(estimate.memory_bytes()) + " of memory; the job has " +
           human_bytes(options.limits.memory_bytes));
  } else if (const auto beyond = check_disk("and need " + human_bytes(cost.result_bytes) + " of disk; ",
                                            cost.result_bytes, shop.limits, shop.data)) {
    refuse(beyond->detail());
  }
  return estimate;
}

Reply<proto::Estimate> estimate_region(const Workshop& shop, const proto::Inputs& inputs,
                                       std::optional<proto::Problem>& /*refused*/) {
  auto told = estimate_boxes(shop, inputs.region());
  return told ? Reply<proto::Estimate>(std::move(told).value())
              : in_callers_words(shop, problem_of_inputs(told.error()));
}

std::optional<proto::Problem> check_region_options(const proto::Inputs& inputs, const JobShare& share) {
  return problem_if(region_options(inputs.region(), share));
}

std::optional<proto::Problem> check_region(const Workshop& shop, const proto::Inputs& inputs) {
  return check_files(shop, inputs.region().inputs(), inputs.region().recursive());
}

}  // namespace

// The cost of a region is known when its files were read, which the job does.
constinit const Process region_process{
    .name = "region",
    .title = "Region",
    .description =
        "Triangulates only a region of point clouds, exactly, and reads only the points that this needs. bbox or "
        "polygon gives the region.",
    .outcome = "The cells, as a result like those of triangulate, by reference",
    .makes = Process::Makes::result,
    .costs = Process::Costs::on_request,
    .check_options = check_region_options,
    .check = check_region,
    .estimate = estimate_region,
    .run = run_region};

}  // namespace tessera::service

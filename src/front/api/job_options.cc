#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/option.h"
#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/input/column_names.h"
#include "src/input/snapshot/particle_types.h"
#include "src/job/machine.h"
#include "src/job/parse_crs.h"
#include "src/tiling/partition.h"

namespace tessera {
namespace {

void require(bool holds, const std::string& otherwise) {
  if (!holds) throw Failure(Cause::usage, otherwise);
}

// Returns the parsed value of the option `key`. The error of a parser is the end of a sentence; the Failure gets its
// beginning.
template <class T>
T checked(Result<T> parsed, const char* key) {
  if (!parsed) throw_failure(error(parsed.error().code, option(key) + ": " + parsed.error().where));
  return std::move(parsed).value();
}

}  // namespace

JobOptions job_options(const TriangulationOptions& options) {
  const auto& asked = OptionsInside::of(options);
  JobOptions job = asked.job;
  const int dimension = job.cloud.dimension;
  require(dimension == 0 || dimension == 2 || dimension == 3, option("dim") + ": must be 0, 2 or 3");
  require(job.threads <= threads_max, option("threads") + ": " + std::to_string(job.threads) +
                                          " is more than the limit, " + std::to_string(threads_max));
  if (job.threads == 0) job.threads = usable_processors();
  job.cloud.threads = job.threads;
  if (job.memory_bytes == 0) job.memory_bytes = default_memory();
  require(job.tiles <= Partition::tiles_max,
          option("tiles") + ": more than " + std::to_string(Partition::tiles_max) + " tiles are not possible");
  require(job.tiles == 0 || job.max_points_per_tile == 0,
          option("tiles") + " and " + option("max-points-per-tile") + " contradict each other: give one of them");
  job.partition = checked(parse_partition_kind(asked.partition), "partition");
  if (!asked.crop.empty()) job.cloud.crop = checked(crop_box(asked.crop, dimension == 2 ? 2 : 3), "crop");
  if (!asked.crs.empty()) job.cloud.crs = checked(parse_crs(asked.crs), "crs");
  require(asked.periodic_snap == "yes" || asked.periodic_snap == "no",
          option("periodic-snap") + ": '" + asked.periodic_snap + "' is neither yes nor no");
  job.cloud.snap = asked.periodic_snap == "yes";
  job.store = checked(parse_store_as(asked.store), "store");
  job.cloud.keep = checked(parse_kept_point(asked.keep), "keep");
  job.cloud.returns = checked(parse_returns(asked.returns), "returns");
  if (const Status known = check_flags(job.cloud.without); !known) checked(Result<int>(known.error()), "without");
  if (const Status named = check_columns(job.cloud.columns); !named) checked(Result<int>(named.error()), "columns");
  job.cloud.particles = checked(snapshot::types_of_names(asked.particles), "particles");
  if (job.cloud.cosmology) {
    const std::string why = why_no_cosmology(*job.cloud.cosmology);
    require(why.empty(), option("cosmology") + ": " + why);
  }
  const auto is_class = [](int number) { return number >= 0 && number <= 255; };
  require(std::all_of(job.cloud.classes.begin(), job.cloud.classes.end(), is_class),
          option("class") + ": LAS has the classes 0 to 255");
  require(std::isfinite(job.cloud.resolution) && job.cloud.resolution >= 0,
          option("resolution") + ": must be a distance, above 0, or 0 for all levels");
  require(!asked.resume || !asked.overwrite,
          option("resume") + " and " + option("overwrite") + " contradict each other: give one of them");
  require(!asked.resume || !asked.folder.empty(),
          option("resume") + ": an unfinished run stays in the result folder, so name one");
  job.resumable = asked.resume;
  job.command = {"tessera::triangulate"};
  return job;
}

}  // namespace tessera

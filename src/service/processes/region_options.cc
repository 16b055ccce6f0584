// Converts the inputs of the process region to options.
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "src/base/option.h"
#include "src/result/query/area.h"
#include "src/service/json.h"
#include "src/service/processes/convert.h"
#include "src/service/processes/refuse.h"
#include "src/tiling/budget/budget.h"

namespace tessera::service {
namespace {

Status read_place(const proto::RegionInputs& inputs, RegionJobOptions& options) {
  if (inputs.has_polygon() == (inputs.bbox_size() > 0))
    return error(Errc::usage, "give either " + option("bbox") + " or " + option("polygon"));
  if (inputs.has_polygon()) {
    if (nested_too_deep(inputs.polygon())) return refuse("polygon", "lists are nested too deep for GeoJSON");
    auto read = query::Polygon::of_geojson(inputs.polygon(), option("polygon"));
    if (!read) return error(Errc::usage, read.error().where);
    const Bounds& around = read.value().bounds();
    constexpr double inf = std::numeric_limits<double>::infinity();
    options.box = Box{{around.lo.x, around.lo.y, -inf}, {around.hi.x, around.hi.y, inf}};
    options.check_place = [place = read.value().place()](const std::string& crs, const Bounds& points) {
      return place.check_in(crs, points);
    };
    options.shape = [area = std::move(read).value()](std::span<const Point> cell) { return area.meets(cell); };
    return success();
  }
  const std::vector<double> numbers(inputs.bbox().begin(), inputs.bbox().end());
  for (const double number : numbers)
    if (!std::isfinite(number)) return refuse("bbox", "is not a box: one of its numbers is not finite");
  const auto box = crop_box(numbers, options.cloud.dimension == 2 ? 2 : 3);
  if (!box) return refuse("bbox", box.error().where);
  options.box = box.value();
  return success();
}

}  // namespace

Result<RegionJobOptions> region_options(const proto::RegionInputs& inputs, const JobShare& share) {
  BOOST_OUTCOME_TRY(cloud, cloud_of(inputs));
  BOOST_OUTCOME_TRY(job, job_options(cloud, share));
  RegionJobOptions options;
  options.cloud = job.cloud;
  options.cloud.threads = budget::reading_threads(job.memory_bytes, job.threads);
  options.neighbors = job.neighbors;
  options.scan_files = inputs.scan_files();
  options.limits.memory_bytes = job.memory_bytes;
  options.limits.partial = inputs.partial();
  if (inputs.has_max_points()) options.limits.max_points = inputs.max_points();
  if (inputs.has_max_seconds()) {
    BOOST_OUTCOME_TRY(seconds, length_of("max-seconds", inputs.max_seconds()));
    options.limits.max_seconds = seconds;
  }
  BOOST_OUTCOME_TRYV(read_place(inputs, options));
  return options;
}

}  // namespace tessera::service

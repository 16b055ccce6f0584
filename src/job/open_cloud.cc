#include "src/job/open_cloud.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/option.h"
#include "src/job/estimate.h"
#include "src/tiling/budget/budget.h"

namespace tessera {

Result<Cloud> open_cloud(const std::vector<std::string>& inputs, JobOptions& options, std::stop_token stop) {
  options.cloud.threads = budget::reading_threads(options.memory_bytes, options.cloud.threads);
  const bool open_dimension = options.cloud.dimension == 0;
  BOOST_OUTCOME_TRY(cloud, Cloud::open(inputs, options.cloud, std::move(stop)));
  options.cloud.dimension = cloud.options().dimension;
  if (open_dimension && options.cloud.dimension == 2 && options.cloud.crop && std::isfinite(options.cloud.crop->lo.z)) {
    return error(Errc::usage, option("crop") + ": the files hold only x and y; give xmin,ymin,xmax,ymax");
  }
  return std::move(cloud);
}

Result<std::uint64_t> tile_limit(const JobOptions& options, const Cloud& cloud,
                                 std::span<const budget::NodeShare> nodes) {
  const int dimension = options.cloud.dimension;
  const auto points = expected_points(cloud.files());
  std::uint64_t limit = options.max_points_per_tile;
  if (options.tiles > 0) {
    limit = points / options.tiles + 1;
  } else if (limit == 0) {
    BOOST_OUTCOME_TRY(fitting,
                      budget::tile_limit(dimension, options.kernel, points, options.threads, options.memory_bytes));
    if (nodes.empty()) return fitting;
    const std::uint64_t most = budget::tile_points_max(dimension, options.kernel, nodes);
    if (most == 0) {
      BOOST_OUTCOME_TRYV(budget::tile_fits_a_node(dimension, options.kernel, std::min(points, fitting), nodes));
    }
    return std::min(fitting, most);
  }
  const std::uint64_t tiles = options.tiles > 0 ? options.tiles : points / std::max<std::uint64_t>(1, limit) + 1;
  BOOST_OUTCOME_TRYV(budget::tile_fits(dimension, options.kernel, std::min(limit, points), tiles, options.threads,
                                       options.memory_bytes));
  if (!nodes.empty()) {
    BOOST_OUTCOME_TRYV(budget::tile_fits_a_node(dimension, options.kernel, std::min(limit, points), nodes));
  }
  return limit;
}

}  // namespace tessera

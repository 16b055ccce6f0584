#include "src/apps/job.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "src/apps/plan.h"

namespace tessera {

Result<Cloud> open_cloud(TriangulateOptions& options, std::stop_token stop) {
  if (!options.out.empty()) {
    // Where the result goes there is room for the points.
    std::error_code gone;
    auto folder = std::filesystem::absolute(options.out, gone).lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();  // "out/"
    options.cloud.spool_folder = std::filesystem::is_directory(folder, gone) ? folder : folder.parent_path();
  }
  const bool open_dimension = options.cloud.dimension == 0;
  BOOST_OUTCOME_TRY(cloud, Cloud::open(options.inputs, options.cloud, std::move(stop)));
  options.cloud.dimension = cloud.options().dimension;
  if (open_dimension && options.cloud.dimension == 2 && options.cloud.crop && std::isfinite(options.cloud.crop->lo.z)) {
    return error(Errc::usage, "--crop: the files hold x and y alone; give xmin,ymin,xmax,ymax");
  }
  return std::move(cloud);
}

Result<std::uint64_t> tile_limit(const TriangulateOptions& options, const Cloud& cloud) {
  const int dimension = options.cloud.dimension;
  const auto points = expected_points(cloud.files());
  std::uint64_t limit = options.max_points_per_tile;
  if (options.tiles > 0) {
    limit = points / options.tiles + 1;
  } else if (limit == 0) {
    return choose_tile_limit(dimension, points, {.memory_bytes = options.memory_bytes, .threads = options.threads});
  }
  BOOST_OUTCOME_TRYV(check_tile_fits(dimension, std::min(limit, points), options.memory_bytes));
  return limit;
}

}  // namespace tessera

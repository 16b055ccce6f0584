#include "src/job/inputs.h"

#include <algorithm>
#include <cmath>

#include "src/job/plan.h"

namespace tessera {

Result<Cloud> open_cloud(const std::vector<std::string>& inputs, JobOptions& options) {
  if (options.cloud.dimension == 0) {
    CloudOptions anything;
    anything.dimension = 2;
    BOOST_OUTCOME_TRY(files, Cloud::open(inputs, anything));
    const bool flat =
        std::all_of(files.files().begin(), files.files().end(), [](const auto& f) { return f.dimension == 2; });
    options.cloud.dimension = flat ? 2 : 3;
    if (flat && options.cloud.crop && std::isfinite(options.cloud.crop->lo.z)) {
      return error(Errc::usage, "--crop: the files hold x and y alone; give xmin,ymin,xmax,ymax");
    }
  }
  return Cloud::open(inputs, options.cloud);
}

Result<std::uint64_t> tile_limit(const JobOptions& options, const Cloud& cloud) {
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

#include "src/result/heights/heights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/thread_name.h"
#include "src/input/cloud/batch_queue.h"
#include "src/input/cloud/cloud.h"

namespace tessera {
namespace {

// The points of a file in its order. A thread of its own reads them.
class PointFeed {
 public:
  explicit PointFeed(const Cloud& cloud) {
    reader_ = std::thread([this, &cloud] {
      name_thread("points");
      auto counts = cloud.for_each_batch([this](CloudBatch& batch) -> Status {
        if (queue_.push(batch)) return success();
        return error(Errc::interrupted, "no more points are needed");
      });
      queue_.finish(counts ? Status(success()) : Status(counts.error()));
    });
  }
  ~PointFeed() {
    queue_.close();
    reader_.join();
  }
  PointFeed(const PointFeed&) = delete;
  PointFeed& operator=(const PointFeed&) = delete;

  // The next `count` points. Error corrupt when the file has fewer.
  Status next(std::size_t count, std::vector<Point>& points) {
    points.clear();
    while (points.size() < count) {
      if (at_ == batch_.points.size()) {
        at_ = 0;
        if (!queue_.pop(batch_)) {
          batch_ = {};
          BOOST_OUTCOME_TRYV(queue_.status());
          return error(Errc::corrupt, "the file has fewer points than records");
        }
        continue;
      }
      const std::size_t more = std::min(count - points.size(), batch_.points.size() - at_);
      for (std::size_t i = 0; i < more; ++i) points.push_back(batch_.points[at_ + i].at);
      at_ += more;
    }
    return success();
  }

 private:
  BatchQueue queue_;
  CloudBatch batch_;
  std::size_t at_ = 0;
  std::thread reader_;
};

Status check_surface(const query::StoredTriangulation& ground, const Cloud& cloud) {
  const Manifest& manifest = ground.manifest();
  if (manifest.dimension != 2)
    return error(Errc::usage, "the surface is a 3D result; heights are measured above a 2D result");
  if (manifest.region)
    return error(Errc::usage, "the surface is a region, which does not hold all triangles of its surroundings");
  if (!manifest.crs.empty() && !cloud.crs().empty() && manifest.crs != cloud.crs())
    return error(Errc::usage, cloud.files().front().path.string() +
                                  ": has another coordinate system than the surface; heights need one system");
  return success();
}

}  // namespace

Result<HeightsCopy> copy_with_heights(const query::StoredTriangulation& ground, const std::filesystem::path& input,
                                      const std::filesystem::path& to, const HeightsOptions& options) {
  BOOST_OUTCOME_TRY(cloud, Cloud::open({input.string()}, {.dimension = 3, .threads = options.threads}, options.stop));
  BOOST_OUTCOME_TRYV(check_surface(ground, cloud));
  BOOST_OUTCOME_TRY(source, cloud.source(0));
  HeightsCopy made;
  PointFeed feed(cloud);
  std::vector<Point> points, places;
  const double outside = options.outside.value_or(std::numeric_limits<double>::quiet_NaN());
  const auto heights = [&](std::uint64_t /*first*/, std::span<double> values) -> Status {
    BOOST_OUTCOME_TRYV(feed.next(values.size(), points));
    places.clear();
    for (const Point& p : points) places.push_back({p.x, p.y, 0});
    BOOST_OUTCOME_TRY(below, ground.interpolate(places, {.value = "z"}, {options.threads, options.stop}));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool known = !std::isnan(below[i].value);
      values[i] = known ? points[i].z - below[i].value : outside;
      made.outside += known ? 0 : 1;
    }
    return success();
  };
  const LasCopyOptions copying{.packing = options.packing,
                               .dimensions = {{.name = height_dimension, .description = "height above the ground"}},
                               .replace = options.replace,
                               .threads = options.threads,
                               .stop = options.stop};
  BOOST_OUTCOME_TRY(count, copy_las(std::move(source), to, copying, heights));
  made.points = count;
  return made;
}

}  // namespace tessera

// What regions of files cost to read, by hand:
//   region_cost make POINTS FILE.copc.laz           writes a made-up airborne block
//   region_cost DIMENSION REGIONS HALF_HEIGHT FILE...   asks for as many random squares that are 1 % of the files'
//   ground
//     each, and tells how many times its share of the points each read. HALF_HEIGHT: in 3D, of the box around the
//     height of a random point; 0: from the lowest to the highest.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "src/base/option.h"
#include "src/input/cloud/cloud_units.h"
#include "src/input/generate/generate.h"
#include "src/result/region/regions.h"
#include "tests/region/copc_file.h"

namespace tessera {
namespace {

int fail(const Error& error) { return std::fprintf(stderr, "%s\n", in_plain_words(error.where).c_str()), 1; }

int make(std::uint64_t points, const std::string& path) {
  PointGenerator generator({.shape = CloudShape::terrain, .points = points});
  testing_region::CopcFile file;
  const Bounds bounds = generator.bounds();
  for (std::size_t axis = 0; axis < 3; ++axis) file.offset[axis] = std::floor(bounds.lo[static_cast<int>(axis)]);
  std::vector<Point> batch;
  std::vector<std::uint8_t> classes;
  while (file.points.size() < points) {
    generator.next(batch, classes);
    for (const Point& p : batch) {
      std::array<std::int32_t, 3> record{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        record[axis] =
            static_cast<std::int32_t>(std::lround((p[static_cast<int>(axis)] - file.offset[axis]) / file.scale[axis]));
      file.points.push_back(record);
    }
  }
  const auto bytes = file.bytes();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return 0;
}

int measure(int dimension, int regions, double half_height, const std::vector<std::string>& files) {
  const auto open = [&]() -> Result<std::unique_ptr<CloudUnits>> {
    BOOST_OUTCOME_TRY(cloud, Cloud::open(files, {.dimension = dimension, .heights = false}));
    return CloudUnits::open(std::move(cloud), false);
  };
  // Where there are points, and how many in each region.
  const auto whole = Cloud::open(files, {});
  if (whole.has_error()) return fail(whole.error());
  std::vector<Point> points;
  Bounds bounds;
  const auto read = whole.value().for_each_batch([&](CloudBatch& batch) -> Status {
    for (const auto& p : batch.points) points.push_back(p.at), bounds.add(p.at);
    return success();
  });
  if (read.has_error()) return fail(read.error());
  auto units = open();
  if (units.has_error()) return fail(units.error());
  Regions cloud(std::move(units).value(), dimension, 0);

  std::mt19937_64 random(1);
  std::vector<double> times;
  const double side = std::sqrt((bounds.hi.x - bounds.lo.x) * (bounds.hi.y - bounds.lo.y) / 100);
  while (static_cast<int>(times.size()) < regions) {
    const Point at = points[random() % points.size()];
    Box box{{at.x - side / 2, at.y - side / 2}, {at.x + side / 2, at.y + side / 2}};
    if (box.lo.x < bounds.lo.x || box.lo.y < bounds.lo.y || box.hi.x > bounds.hi.x || box.hi.y > bounds.hi.y) continue;
    const bool all_heights = dimension == 2 || half_height == 0;
    box.lo.z = all_heights ? -INFINITY : at.z - half_height;
    box.hi.z = all_heights ? INFINITY : at.z + half_height;
    const auto share = static_cast<double>(std::count_if(points.begin(), points.end(), [&](const Point& p) {
      return p.x >= box.lo.x && p.x <= box.hi.x && p.y >= box.lo.y && p.y <= box.hi.y;
    }));
    cloud.forget();
    const auto answer = cloud.ask(box, {});
    if (answer.has_error()) return fail(answer.error());
    const RegionFigures& f = answer.value().figures;
    times.push_back(static_cast<double>(f.points_read) / share);
    std::printf(
        "%9.0f points there, %9llu read of %llu (%.2f times), %5llu of %llu units, %2llu rounds, %9zu cells, %.2f s\n",
        share, static_cast<unsigned long long>(f.points_read), static_cast<unsigned long long>(f.points), times.back(),
        static_cast<unsigned long long>(f.units_read), static_cast<unsigned long long>(f.units),
        static_cast<unsigned long long>(f.rounds), answer.value().final.size(), f.seconds);
    std::fflush(stdout);
  }
  std::sort(times.begin(), times.end());
  std::printf("read %.2f times the region's share in the median, %.2f at most\n", times[times.size() / 2],
              times.back());
  return 0;
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  const std::vector<std::string> args(argv + 1, argv + argc);
  if (args.size() == 3 && args[0] == "make") return tessera::make(std::strtoull(args[1].c_str(), nullptr, 10), args[2]);
  if (args.size() >= 4) {
    return tessera::measure(std::atoi(args[0].c_str()), std::atoi(args[1].c_str()), std::atof(args[2].c_str()),
                            {args.begin() + 3, args.end()});
  }
  std::fputs("usage: region_cost make POINTS FILE | region_cost DIMENSION REGIONS HALF_HEIGHT FILE...\n", stderr);
  return 2;
}

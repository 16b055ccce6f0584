// Points per second of looking up tiles, of routing into files, and of ordering a tile, on one thread.
//   bench_tiling [points=10000000] [tiles=64] [seed=7] [folder=/tmp]
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile_writer.h"

namespace tessera {
namespace {

double seconds(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void print(const std::string& what, std::size_t points, double s) {
  std::printf("%-28s %8.1f M points/s   %7.4f us a point\n", what.c_str(), static_cast<double>(points) / s / 1e6,
              s / static_cast<double>(points) * 1e6);
}

int run(std::size_t n, std::uint32_t tiles, unsigned seed, const std::filesystem::path& folder) {
  std::printf("%zu uniform points, %u tiles, seed %u\n", n, tiles, seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<LocalPoint> points(n);
  for (std::size_t i = 0; i < n; ++i) points[i] = {{unit(random), unit(random), unit(random)}, i};
  std::vector<Point> sample;
  Bounds bounds;
  const std::size_t stride = n / 1'000'000 + 1;
  for (std::size_t i = 0; i < n; i += stride) {
    sample.push_back(points[i].at);
    bounds.add(points[i].at);
  }

  constexpr std::size_t batch = 65536;
  for (const PartitionKind kind :
       {PartitionKind::kdtree, PartitionKind::grid, PartitionKind::octree, PartitionKind::random}) {
    Partition partition;
    const std::string name = name_of(kind);
    print("build from the sample " + name, sample.size(),
          seconds([&] { partition = Partition::build_tiles(kind, 3, sample, bounds, tiles); }));
    std::uint64_t sum = 0;
    print("tile_of " + name, n, seconds([&] {
            for (const LocalPoint& p : points) sum += partition.tile_of(p.at).value;
          }));
    const auto run_folder = folder / ("bench_tiling_" + std::to_string(::getpid()));
    std::filesystem::create_directories(points_folder(run_folder));
    bool written = true;
    std::uint64_t routed = 0;
    print("route " + name, n, seconds([&] {
            TileWriter writer(run_folder, 0, 3, 0, std::uint64_t{128} << 20);
            for (std::size_t i = 0; i < n && written; i += batch) {
              const auto part = std::span(points).subspan(i, std::min(batch, n - i));
              written = writer.add(partition, part, {}).has_value();
            }
            written = written && writer.flush(partition).has_value();
            for (const ShuffleFile& bundle : writer.routed().bundles) routed += bundle.points;
          }));
    std::filesystem::remove_all(run_folder);
    if (!written || routed != n || sum == 0) {
      std::fprintf(stderr, "%s: cannot write\n", run_folder.c_str());
      return 4;
    }
  }

  const std::size_t tile = std::min<std::size_t>(n, 1'000'000);
  std::vector<LocalPoint> some(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(tile));
  std::size_t vertices = 0;
  print("order_points 3D", tile, seconds([&] { vertices = order_points(some, 3).points.size(); }));
  for (LocalPoint& p : some) p.at.z = 0;
  print("order_points 2D", tile, seconds([&] { vertices += order_points(some, 2).points.size(); }));
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  std::printf("%zu vertices; peak memory %ld MB, of which %zu MB are the bench's own points\n", vertices,
              usage.ru_maxrss / 1024, (n * sizeof(LocalPoint) + sample.size() * sizeof(Point)) >> 20);
  return 0;
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  const auto number = [&](int i, unsigned long fallback) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : fallback;
  };
  const auto n = number(1, 10'000'000);
  const auto tiles = number(2, 64);
  if (n == 0 || tiles == 0) {
    std::fprintf(stderr, "bench_tiling [points] [tiles] [seed] [folder]: points and tiles are positive numbers\n");
    return 2;
  }
  return tessera::run(n, static_cast<std::uint32_t>(tiles), static_cast<unsigned>(number(3, 7)),
                      argc > 4 ? argv[4] : "/tmp");
}

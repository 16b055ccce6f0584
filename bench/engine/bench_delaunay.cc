// The public library's Delaunay, in memory, against CGAL alone: random points in the unit square and cube, and looking
// for the simplices that hold others.
//
//   bench_delaunay [points...]        default: 10 1000 1000000
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <random>
#include <vector>

#include "bench/engine/cgal_sequential.h"
#include "tessera/delaunay.h"

namespace tessera {
namespace {

std::vector<double> random_coordinates(std::size_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<double> list(n);
  std::generate(list.begin(), list.end(), [&] { return coordinate(random); });
  return list;
}

// Of processor time, which is all there is: each works in this one thread. The least of three rounds; small work is
// repeated within each.
template <class Work>
double seconds_of(std::size_t repeats, Work&& work) {
  std::clock_t least = std::numeric_limits<std::clock_t>::max();
  for (int round = 0; round < 3; ++round) {
    const std::clock_t begin = std::clock();
    for (std::size_t i = 0; i < repeats; ++i) work();
    least = std::min(least, std::clock() - begin);
  }
  return static_cast<double>(least) / CLOCKS_PER_SEC / static_cast<double>(repeats);
}

void measure(std::size_t n, int dimension) {
  const auto d = static_cast<std::size_t>(dimension);
  const auto coordinates = random_coordinates(n * d, 1);
  std::vector<Point> points;
  for (std::size_t i = 0; i < n * d; i += d) {
    points.push_back({coordinates[i], coordinates[i + 1], d == 3 ? coordinates[i + 2] : 0});
  }
  const std::size_t repeats = std::max<std::size_t>(1, 100'000 / n);
  const double ours = seconds_of(repeats, [&] { const Delaunay t(coordinates, dimension); });
  const double cgal = seconds_of(repeats, [&] { cgal_sequential(points, dimension); });

  const Delaunay t(coordinates, dimension);
  const auto queries = random_coordinates(1'000'000 * d, 2);
  std::vector<std::int32_t> found(queries.size() / d);
  const double all = seconds_of(1, [&] { t.find_simplex(queries, found); });
  std::printf(
      "%dD %8zu points   Delaunay %12.1f us   CGAL %12.1f us   %5.2f times CGAL   find_simplex %.3f us a query\n",
      dimension, n, ours * 1e6, cgal * 1e6, cgal / ours, all * 1e6 / static_cast<double>(found.size()));
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  std::vector<std::size_t> sizes;
  for (int i = 1; i < argc; ++i) sizes.push_back(std::strtoull(argv[i], nullptr, 10));
  if (sizes.empty()) sizes = {10, 1000, 1'000'000};
  for (const int dimension : {2, 3}) {
    for (const std::size_t n : sizes) tessera::measure(n, dimension);
  }
}

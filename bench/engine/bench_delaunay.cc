// The public library's Delaunay, in memory, against CGAL alone: random points in the unit square and cube, and looking
// for the simplices that hold others.
//
//   bench_delaunay [points...]        default: 10 1000 1000000
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
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

template <class Work>
double seconds_of(Work&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// The least of three rounds; small work is repeated within each.
template <class Work>
double least_seconds(std::size_t repeats, Work&& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 3; ++round) {
    double sum = 0;
    for (std::size_t i = 0; i < repeats; ++i) sum += work();
    least = std::min(least, sum / static_cast<double>(repeats));
  }
  return least;
}

void measure(std::size_t n, int dimension) {
  const auto d = static_cast<std::size_t>(dimension);
  const auto coordinates = random_coordinates(n * d, 1);
  std::vector<Point> points;
  for (std::size_t i = 0; i < n * d; i += d) {
    points.push_back({coordinates[i], coordinates[i + 1], d == 3 ? coordinates[i + 2] : 0});
  }
  const std::size_t repeats = std::max<std::size_t>(1, 100'000 / n);
  const double ours =
      least_seconds(repeats, [&] { return seconds_of([&] { const Delaunay t(coordinates, dimension); }); });
  const double cgal = least_seconds(repeats, [&] { return cgal_sequential(points, dimension).seconds; });

  const Delaunay t(coordinates, dimension);
  const auto queries = random_coordinates(1'000'000 * d, 2);
  std::vector<std::int32_t> found(queries.size() / d);
  const double all = least_seconds(1, [&] { return seconds_of([&] { t.find_simplex(queries, found); }); });
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

// Nanoseconds per call of the exact predicates, by the stage that decides, beside CGAL's. Usage: bench_predicates
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;
using Five = std::array<Point, 5>;
using Rng = std::mt19937_64;
constexpr std::size_t calls = 20000;  // 2.4 MB of points: in the second level cache, as a tile's frontier is
constexpr int repeats = 5;

volatile int sink = 0;

template <class Predicate>
double nanoseconds(const std::vector<Five>& sets, Predicate&& predicate) {
  double best = 1e300;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    int sum = 0;
    for (const Five& p : sets) sum += predicate(p);
    sink = sum;
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - start;
    best = std::min(best, took.count() / static_cast<double>(sets.size()));
  }
  return best;
}

template <class Predicate, class Reference, class Staged>
void report(const char* set, const char* name, const std::vector<Five>& sets, Predicate&& predicate,
            Reference&& reference, Staged&& staged) {
  std::array<double, 5> stages{};
  for (const Five& p : sets)
    stages[static_cast<std::size_t>(staged(p).stage)] += 100.0 / static_cast<double>(sets.size());
  std::printf(
      "%-12s %-9s %8.1f ns  CGAL %8.1f ns   %%: filter %6.2f lattice %6.2f integer %6.2f wide %6.2f big %6.2f\n", set,
      name, nanoseconds(sets, predicate), nanoseconds(sets, reference), stages[0], stages[1], stages[2], stages[3],
      stages[4]);
}

K::Point_3 c3(const Point& p) { return {p.x, p.y, p.z}; }
K::Point_2 c2(const Point& p) { return {p.x, p.y}; }

template <class Draw>
void run(const char* name, Draw&& draw) {
  std::vector<Five> sets(calls);
  for (Five& set : sets) {
    for (Point& p : set) p = draw();
  }
  using namespace exact;
  report(
      name, "orientation_2", sets, [](const Five& p) { return orientation_2(p[0], p[1], p[2]); },
      [](const Five& p) { return static_cast<int>(CGAL::orientation(c2(p[0]), c2(p[1]), c2(p[2]))); },
      [](const Five& p) { return orientation_2_staged(p[0], p[1], p[2]); });
  report(
      name, "in_circle_2", sets, [](const Five& p) { return in_circle_2(p[0], p[1], p[2], p[3]); },
      [](const Five& p) {
        return static_cast<int>(CGAL::side_of_oriented_circle(c2(p[0]), c2(p[1]), c2(p[2]), c2(p[3])));
      },
      [](const Five& p) { return in_circle_2_staged(p[0], p[1], p[2], p[3]); });
  report(
      name, "orientation_3", sets, [](const Five& p) { return orientation_3(p[0], p[1], p[2], p[3]); },
      [](const Five& p) { return static_cast<int>(CGAL::orientation(c3(p[0]), c3(p[1]), c3(p[2]), c3(p[3]))); },
      [](const Five& p) { return orientation_3_staged(p[0], p[1], p[2], p[3]); });
  report(
      name, "in_sphere_3", sets, [](const Five& p) { return in_sphere_3(p[0], p[1], p[2], p[3], p[4]); },
      [](const Five& p) {
        return static_cast<int>(CGAL::side_of_oriented_sphere(c3(p[0]), c3(p[1]), c3(p[2]), c3(p[3]), c3(p[4])));
      },
      [](const Five& p) { return in_sphere_3_staged(p[0], p[1], p[2], p[3], p[4]); });
}

}  // namespace
}  // namespace tessera

int main() {
  tessera::Rng rng(1);
  const auto unit = [&] { return std::uniform_real_distribution<>(0, 1)(rng); };
  const auto below = [&](std::uint64_t n) { return static_cast<double>(rng() % n); };
  std::printf("seed 1, %zu calls, best of %d\n", tessera::calls, tessera::repeats);
  tessera::run("uniform", [&] { return tessera::Point{unit(), unit(), unit()}; });
  // Neighbours in a survey: 1 cm steps within a metre, 10 cm of relief.
  tessera::run("survey", [&] {
    return tessera::Point{(84000000 + below(100)) * 0.01, (680000000 + below(100)) * 0.01, (13000 + below(10)) * 0.01};
  });
  tessera::run("survey ties", [&] {
    return tessera::Point{(84000000 + below(3)) * 0.01, (680000000 + below(3)) * 0.01, (13000 + below(3)) * 0.01};
  });
  tessera::run("lattice", [&] { return tessera::Point{below(3), below(3), below(3)}; });
  tessera::run("ties", [&] {  // integer points of a sphere and of circles
    const auto s = [&](double v) { return below(2) != 0 ? v : -v; };
    std::array<double, 3> v{s(15), s(20), 0};
    if (below(2) != 0) std::swap(v[0], v[1]);
    return tessera::Point{v[0], v[1], s(below(2) * 3)};
  });
  tessera::run("sphere", [&] {
    const double z = 2 * unit() - 1, t = 6.283185307179586 * unit(), r = std::sqrt(1 - z * z);
    return tessera::Point{r * std::cos(t), r * std::sin(t), z};
  });
  tessera::run("circle", [&] {
    const double t = 6.283185307179586 * unit();
    return tessera::Point{std::cos(t), std::sin(t), 0};
  });
  tessera::run("magnitudes", [&] { return tessera::Point{below(2) * 1e300, below(2) * 1e-300, below(3)}; });
}

// What is bad for the kernels: one conflict zone of nearly all cells, and points on both sides of a thin hole of frozen
// cells. Microseconds an insertion (of this thread's processor time) and bytes.
//
//   taskset -c 1 bench_worst_cases centre 200000
//   taskset -c 1 bench_worst_cases slab 100000
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "src/geometry/kernel/kernel.h"
#include "src/tiling/tile/circumsphere.h"

namespace {

using namespace tessera;

double seconds() {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

void insert(Kernel& kernel, const char* what, std::span<const Point> points, std::size_t vertices) {
  double all = 0, worst = 0;
  std::vector<Vertex> around;
  for (const Point& p : points) {
    const double begin = seconds();
    kernel.insert(p, false, InsertMode::if_local_neighbour, around);
    const double took = seconds() - begin;
    all += took;
    worst = std::max(worst, took);
  }
  std::printf("%-28s %10.1f us each, worst %9.1f us, then %5.0f bytes a point\n", what,
              1e6 * all / static_cast<double>(points.size()), 1e6 * worst,
              static_cast<double>(kernel.memory()) / static_cast<double>(vertices));
}

// Near the unit sphere (noise 1e-6), its centre, and 3,000 points more.
void centre(std::size_t n, KernelKind kind, const char* name) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
  std::vector<Point> points;
  while (points.size() < n) {
    const Point p{normal(random), normal(random), normal(random)};
    const double scale = (1 + noise(random)) / std::hypot(p.x, p.y, p.z);
    points.push_back({p.x * scale, p.y * scale, p.z * scale});
  }
  const std::size_t later = std::min<std::size_t>(3000, n / 2);
  const auto kernel = make_kernel(3, kind);
  kernel->build(std::span(points).first(n - later), KeepPoints::borrowed);
  const Point middle{1e-9, 2e-9, 0};
  insert(*kernel, (std::string(name) + ": the centre").c_str(), {&middle, 1}, n);
  insert(*kernel, (std::string(name) + ": what follows").c_str(), std::span(points).last(later), n);
}

// 1 x 1 x 0.05, and 4,000 points above or below, in random order.
void slab(std::size_t n, KernelKind kind, bool frozen, const char* name) {
  constexpr double height = 0.05, far = std::numeric_limits<double>::max() / 4;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Point> points, foreign;
  for (std::size_t i = 0; i < n; ++i) points.push_back({unit(random), unit(random), height * unit(random)});
  std::sort(points.begin(), points.end());
  const double apart = std::cbrt(height / static_cast<double>(n));
  for (int i = 0; i < 4000; ++i) {
    const double out = apart * (0.01 + unit(random));
    foreign.push_back({unit(random), unit(random), random() % 2 ? -out : height + out});
  }
  const auto kernel = make_kernel(3, kind);
  kernel->build(points, KeepPoints::borrowed);
  if (frozen) {
    kernel->freeze([&](const Vertex* v) {
      const Ball ball = circumsphere(points[v[0] - 1], points[v[1] - 1], points[v[2] - 1], points[v[3] - 1]);
      return surely_inside(ball, {{-far, -far, 0}, {far, far, height}}, 3);
    });
  }
  insert(*kernel, name, foreign, n);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc == 3 ? argv[1] : "";
  const std::size_t n = argc == 3 ? std::strtoull(argv[2], nullptr, 10) : 0;
  if ((what != "centre" && what != "slab") || n < 100) {
    std::fprintf(stderr, "Usage: bench_worst_cases centre|slab POINTS, of which at least 100\n");
    return 2;
  }
  if (what == "centre") {
    centre(n, KernelKind::flat, "flat");
    centre(n, KernelKind::cgal, "CGAL");
  } else {
    slab(n, KernelKind::flat, true, "flat, middle frozen");
    slab(n, KernelKind::flat, false, "flat");
    slab(n, KernelKind::cgal, false, "CGAL");
  }
  return 0;
}

// The kernels alone against CGAL as its users call it: Delaunay_triangulation_3 (or _2)::insert(range), which sorts by
// itself. Ours are given points in Hilbert order; the time for that order is told and counted.
//
//   taskset -c 1 bench_kernel --kind uniform -n 1000000 --kernel flat
//   taskset -c 1 bench_kernel --file scan.las --dimension 2 --kernel flat
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/engine/cgal_sequential.h"
#include "src/base/option.h"
#include "src/base/result.h"
#include "src/geometry/kernel/kernel.h"
#include "src/input/cloud/cloud.h"
#include "src/input/generate/generate.h"
#include "src/tiling/routed_cloud.h"

namespace {

using namespace tessera;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> list) {
  std::sort(list.begin(), list.end());
  return list[list.size() / 2];
}

// A line of /proc/self/status, in bytes.
double status(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    if (word != name + ":") continue;
    double kib = 0;
    file >> kib;
    return kib * 1024;
  }
  return 0;
}

void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

std::vector<LocalPoint> generated(CloudShape shape, std::uint64_t n, std::uint64_t seed, int dimension) {
  std::vector<LocalPoint> points;
  std::vector<Point> batch;
  std::vector<std::uint8_t> classes;
  for (PointGenerator generator({shape, n, seed, dimension}); points.size() < n;) {
    generator.next(batch, classes);
    for (const Point& p : batch) points.push_back({p, points.size()});
  }
  return points;
}

// A file of any format that the programs read, or of doubles x y z (.bin), as gen.py writes them.
Result<std::vector<LocalPoint>> read(const std::string& path, int dimension) {
  std::vector<LocalPoint> points;
  if (path.ends_with(".bin")) {
    std::ifstream file(path, std::ios::binary);
    for (double c[3]; file.read(reinterpret_cast<char*>(c), sizeof c);) {
      points.push_back({without_negative_zero({c[0], c[1], dimension == 2 ? 0 : c[2]}), points.size()});
    }
  } else {
    BOOST_OUTCOME_TRY(cloud, Cloud::open({path}, {.dimension = dimension}));
    BOOST_OUTCOME_TRYV(cloud.for_each_batch([&](CloudBatch& batch) -> Status {
      points.insert(points.end(), batch.points.begin(), batch.points.end());
      return success();
    }));
  }
  if (points.empty()) return error(Errc::bad_input, path + ": no points");
  return points;
}

}  // namespace

int main(int argc, char** argv) {
  std::string kind = "uniform", kernel = "both", file;
  std::uint64_t n = 1'000'000, seed = 7;
  int repeat = 5, dimension = 3;
  CLI::App app("The kernels alone against CGAL");
  app.add_option("--kind", kind, "uniform, normal, sphere, grid, terrain");
  app.add_option("--file", file, "points instead of --kind: LAS, PLY, text, NumPy, or doubles x y z (.bin)");
  app.add_option("-n,--points", n, "points");
  app.add_option("--seed", seed, "seed");
  app.add_option("--dimension", dimension, "2 or 3")->check(CLI::Range(2, 3));
  app.add_option("--repeat", repeat, "runs of each, in turn; the median is told");
  app.add_option("--kernel", kernel, "flat, cgal (its kernel in Tessera) or both; with -1: without CGAL itself")
      ->check(CLI::IsMember({"flat", "cgal", "both", "flat-1", "cgal-1", "both-1"}));
  CLI11_PARSE(app, argc, argv);
  const auto shape = shape_named(kind);
  if (!shape) return 2;
  std::vector<LocalPoint> cloud;
  if (file.empty()) {
    cloud = generated(*shape, n, seed, dimension);
  } else {
    auto from_file = read(file, dimension);
    if (!from_file) {
      std::fprintf(stderr, "bench_kernel: %s\n", tessera::in_plain_words(from_file.error().where).c_str());
      return 1;
    }
    cloud = std::move(from_file.value());
  }
  const bool reference = !kernel.ends_with("-1");
  if (!reference) kernel.resize(kernel.size() - 2);

  LoadedTile tile;
  std::vector<double> order_s;
  for (int run = 0; run < repeat; ++run) {
    tile = {};
    const auto begin = std::chrono::steady_clock::now();
    tile = order_points(cloud, dimension);
    order_s.push_back(seconds_since(begin));
  }
  const double order = median(order_s);
  n = tile.points.size();
  const double per_point = 1 / static_cast<double>(n);
  const std::string what = file.empty() ? kind + ", seed " + std::to_string(seed) : file;
  std::printf("%s, %dD, %llu distinct points, 1 thread, median of %d\n", what.c_str(), dimension,
              static_cast<unsigned long long>(n), repeat);
  std::printf("Hilbert order     %7.3f s  %6.3f us a point\n", order, order * 1e6 * per_point);
  std::vector<double> reference_s;
  struct Candidate {
    const char* name;
    KernelKind kind;
    std::vector<double> s;
    double peak;
    std::size_t cells;
  };
  std::vector<Candidate> candidates;
  if (kernel != "cgal") candidates.push_back({"flat kernel", KernelKind::flat, {}, 0, 0});
  if (kernel != "flat") candidates.push_back({"CGAL kernel", KernelKind::cgal, {}, 0, 0});
  for (int run = 0; run < repeat; ++run) {
    for (Candidate& c : candidates) {
      malloc_trim(0);
      forget_peak();
      const double before = status("VmRSS");
      const auto begin = std::chrono::steady_clock::now();
      const auto k = make_kernel(dimension, c.kind);
      k->build(tile.points, KeepPoints::borrowed);
      c.s.push_back(seconds_since(begin));
      c.peak = std::max(c.peak, status("VmHWM") - before);
      if (run == 0) c.cells = k->cells().vertices.size() / static_cast<std::size_t>(dimension + 1);
    }
    if (reference) {
      std::vector<Point> as_given;
      for (const LocalPoint& p : cloud) as_given.push_back(p.at);
      reference_s.push_back(cgal_sequential(as_given, dimension).seconds);
    }
  }
  const double yardstick = reference ? median(reference_s) : 0;
  if (reference) std::printf("CGAL              %7.3f s  %6.3f us a point\n", yardstick, yardstick * 1e6 * per_point);
  for (const Candidate& c : candidates) {
    const double s = median(c.s);
    std::printf("%s       %7.3f s  %6.3f us a point  %7.0f points/s  %4.0f bytes a point at the peak  %zu cells\n",
                c.name, s, s * 1e6 * per_point, static_cast<double>(n) / s, c.peak * per_point, c.cells);
    if (reference)
      std::printf("  %.2f times CGAL; %.2f with the order counted\n", yardstick / s, yardstick / (s + order));
  }
  return 0;
}

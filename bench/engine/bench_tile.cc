// Where one tile's time and memory go: ordering, triangulating, finding final cells, reducing, collecting.
//
//   bench_tile --kind uniform -n 1000000
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>

#include "src/input/generate/generate.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile/tile_triangulation.h"

int main(int argc, char** argv) {
  using namespace tessera;
  std::string kind = "uniform";
  std::uint64_t n = 1'000'000, seed = 7;
  int dimension = 3;
  bool whole = false, cgal = false;
  CLI::App app("Where one tile's time and memory go");
  app.add_option("--kind", kind, "uniform, normal, sphere, grid, terrain");
  app.add_option("-n,--points", n, "points");
  app.add_option("--seed", seed, "seed");
  app.add_option("--dim", dimension, "2 or 3");
  app.add_flag("--whole", whole, "collect from the whole triangulation, without reducing it");
  app.add_flag("--cgal", cgal, "with CGAL's kernel");
  CLI11_PARSE(app, argc, argv);
  const auto shape = shape_named(kind);
  if (!shape) return 2;
  std::vector<LocalPoint> points;
  std::vector<Point> batch;
  std::vector<std::uint8_t> classes;
  Bounds bounds;
  for (PointGenerator generator({*shape, n, seed, dimension}); points.size() < n;) {
    generator.next(batch, classes);
    for (const Point& p : batch) {
      bounds.add(p);
      points.push_back({p, points.size()});
    }
  }
  auto begin = std::chrono::steady_clock::now();
  timespec cpu{};
  const auto cpu_now = [&] {
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
    return static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec);
  };
  double cpu_begin = cpu_now();
  const auto lap = [&](const char* what, std::size_t bytes) {
    const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const double used = cpu_now() - cpu_begin;
    std::printf("%-14s %7.3f s  %7.3f s of cpu  %6.2f us a point  %5.0f bytes a point\n", what, s, used,
                used * 1e6 / static_cast<double>(n), static_cast<double>(bytes) / static_cast<double>(n));
    begin = std::chrono::steady_clock::now();
    cpu_begin = cpu_now();
  };
  std::printf("%s, %llu points, seed %llu, %dD, one thread\n", kind.c_str(), static_cast<unsigned long long>(n),
              static_cast<unsigned long long>(seed), dimension);
  LoadedTile tile = order_points(points, dimension);
  lap("order", tile.points.size() * 32);
  const Bounds beside{{bounds.hi.x, bounds.lo.y, bounds.lo.z},
                      {2 * bounds.hi.x - bounds.lo.x, bounds.hi.y, bounds.hi.z}};
  const KnownFromStart around({bounds, beside}, {{TileId{1}}, {TileId{0}}}, {});
  TileTriangulation t(
      {TileId{0}, dimension, cgal ? KernelKind::cgal : KernelKind::flat, ExchangeRule::introduce, &around});
  t.triangulate(tile.points, tile.ids);
  lap("triangulate", t.memory());
  const Box box{bounds.lo, bounds.hi};
  PendingFinals finals;
  if (!whole) {
    finals.cells = t.reduce(tile.points, box);
    lap("reduce", t.memory());
  }
  t.announce(tile.points, box);
  t.take_updates();
  lap("announce", t.memory());
  if (!whole) {
    std::printf("  %zu final cells\n", finals.cells.rows.size());
    const auto bytes = t.save();
    lap("save", bytes.size());
    t.load(bytes);
    lap("load", t.memory());
  }
  const CollectedTile collected = t.collect(tile.points, tile.ids, std::move(finals));
  lap("collect", collected.bytes());
}

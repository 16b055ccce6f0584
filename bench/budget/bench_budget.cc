// The memory model beside what resident memory does, phase by phase: one tile is made, put to sleep, woken, told of
// foreign points, collected and stored as a run does it, once reduced and once whole; then twice more as a tile of
// which points are kept.
//
//   bench_budget --folder /tmp/bench [--dim 2] [--cgal] [--kind terrain] [-n 100000]
//
// Exit status 1 if a figure is more than 15 % above the model, or, for uniform points, below it.
#include <malloc.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "src/base/memory_pool.h"
#include "src/input/generate/generate.h"
#include "src/result/store/points_tile.h"
#include "src/result/store/tile_store.h"
#include "src/tiling/budget/budget.h"
#include "src/tiling/routed_cloud.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {
namespace {

struct Options {
  std::string kind = "uniform", folder = "bench-out";
  std::uint64_t points = 100'000, seed = 7;
  int dimension = 3;
  bool cgal = false;
};

// A line of /proc/self/status, in bytes.
std::uint64_t status(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    std::uint64_t kilobytes = 0;
    if (word == name + ":" && file >> kilobytes) return kilobytes * 1024;
  }
  return 0;
}

std::uint64_t resident() {
  malloc_trim(0);
  return status("VmRSS");
}

// What resident memory grows by at most, and what of that stays, while `work` is done.
struct Growth {
  double peak = 0, held = 0;
};
template <class Work>
Growth growth(const Work& work) {
  const std::uint64_t before = resident();
  std::ofstream("/proc/self/clear_refs") << 5;  // the peak starts anew
  work();
  const std::uint64_t peak = status("VmHWM");
  const auto above = [&](std::uint64_t bytes) { return static_cast<double>(bytes) - static_cast<double>(before); };
  return {above(peak), above(resident())};
}

class RoutingTable {
 public:
  explicit RoutingTable(const Options& o) : o_(o) {
    std::printf("%s, %llu points, seed %llu, %dD, %s kernel\n", o.kind.c_str(),
                static_cast<unsigned long long>(o.points), static_cast<unsigned long long>(o.seed), o.dimension,
                o.cgal ? "CGAL's" : "flat");
    std::printf("%-44s %9s %9s %7s\n", "bytes a point", "measured", "model", "ratio");
  }
  void row(const char* what, double bytes, std::uint64_t points, double model) {
    const double measured = bytes / static_cast<double>(points), ratio = measured / model;
    std::printf("%-44s %9.0f %9.0f %7.2f\n", what, measured, model, ratio);
    // Under two MiB the system's pages and the allocator's are what is seen.
    if (model * static_cast<double>(points) < 2 << 20) return;
    // Clouds differ: the model is that of uniform ones, and a bound for the others.
    good_ &= ratio < 1.15 && (ratio > 0.85 || o_.kind != "uniform");
  }
  // Reserved for the worst: nothing is wrong with less.
  void bound(const char* what, double bytes, std::uint64_t points, std::uint64_t model) {
    const double measured = bytes / static_cast<double>(points), ratio = measured / static_cast<double>(model);
    std::printf("%-44s %9.0f %9llu %7.2f (a bound)\n", what, measured, static_cast<unsigned long long>(model), ratio);
    good_ &= ratio < 1.15 || o_.kind != "uniform";
  }
  // For what the model does not name.
  void note(const char* what, double bytes, std::uint64_t points) {
    std::printf("%-44s %9.0f\n", what, bytes / static_cast<double>(points));
  }
  bool good() const { return good_; }

 private:
  const Options& o_;
  bool good_ = true;
};

std::vector<LocalPoint> cloud_of(const Options& o, CloudShape shape, std::uint64_t n) {
  std::vector<LocalPoint> points;
  points.reserve(n);
  std::vector<Point> batch;
  std::vector<std::uint8_t> classes;
  for (PointGenerator generator({shape, n, o.seed, o.dimension}); points.size() < n;) {
    generator.next(batch, classes);
    for (const Point& p : batch) points.push_back({p, points.size()});
  }
  return points;
}

// As a run keeps it: written, and dropped before the next thing is done.
template <class List>
void put(const std::filesystem::path& path, const List& list) {
  const auto bytes = std::as_bytes(std::span(list));
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}
BigVector<std::byte> take(const std::filesystem::path& path) {
  BigVector<std::byte> bytes(std::filesystem::file_size(path));
  std::ifstream(path, std::ios::binary)
      .read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}
LoadedTile load(const std::filesystem::path& path, int dimension) {
  std::vector<LocalPoint> points(std::filesystem::file_size(path) / sizeof(LocalPoint));
  std::ifstream(path, std::ios::binary)
      .read(reinterpret_cast<char*>(points.data()), static_cast<std::streamsize>(points.size() * sizeof(LocalPoint)));
  return order_points(points, dimension);
}

class Bench {
 public:
  Bench(const Options& o, CloudShape shape)
      : o_(o),
        table_(o),
        model_(budget::needs(o.dimension, kernel())),
        model_of_points_(budget::needs(o.dimension, kernel(), TileKind::points)),
        folder_(o.folder),
        options_({TileId{0}, o.dimension, kernel(), ExchangeRule::introduce, &around_}) {
    std::filesystem::create_directories(folder_ / "tiles");
    // The tile is what lies before a plane; as many points behind it as a side of the tile has are its neighbour's.
    const auto side = std::pow(static_cast<double>(o.points), 1 - 1.0 / o.dimension);
    auto points = cloud_of(o, shape, o.points + static_cast<std::uint64_t>(side));
    std::sort(points.begin(), points.end(), [](const LocalPoint& a, const LocalPoint& b) { return a.at < b.at; });
    Bounds bounds;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i < o.points) {
        bounds.add(points[i].at);
      } else {
        beside_.add(points[i].at);
        foreign_.push_back({points[i].at, points[i].id, 1, 0});
      }
    }
    points.resize(o.points);
    std::sort(points.begin(), points.end(), [](const LocalPoint& a, const LocalPoint& b) { return a.id < b.id; });
    put(folder_ / "points.bin", points);
    box_ = {bounds.lo, bounds.hi};
    around_ = KnownFromStart({bounds, beside_}, {{TileId{1}}, {TileId{0}}}, {});
    // What is made or loaded when it is first used: fixed costs, not this tile's.
    std::vector<LocalPoint> few(points.begin(), points.begin() + 100);
    const LoadedTile tile = order_points(few, o.dimension);
    TileTriangulation t(options_);
    t.triangulate(tile.points, tile.ids);
    const CollectedTile collected = t.collect(tile.points, tile.ids, {});
    if (!write_tile(folder_, TileId{0}, collected.mesh, collected, {}, {})) std::puts("cannot be stored");
  }

  bool run() {
    reduced();
    whole();
    as_points(true);
    as_points(false);
    return table_.good();
  }

 private:
  double model(std::uint64_t tile_bytes) const {
    return static_cast<double>(tile_bytes) / static_cast<double>(o_.points);
  }
  KernelKind kernel() const { return o_.cgal ? KernelKind::cgal : KernelKind::flat; }

  void triangulate(TileTriangulation& t, const LoadedTile& tile, KeepPoints keep, bool reduce) {
    t.triangulate(tile.points, tile.ids, keep);
    if (reduce) {
      const FinalCells finals = t.reduce(tile.points, box_);
      put(folder_ / "finals.bin", std::as_bytes(std::span(finals.rows.data(), finals.rows.size())));
    }
    t.announce(tile.points, box_);
  }

  PendingFinals finals() const {
    const auto bytes = take(folder_ / "finals.bin");
    PendingFinals finals;
    finals.cells.rows.resize(bytes.size() / sizeof(CellRecord));
    std::memcpy(finals.cells.rows.data(), bytes.data(), bytes.size());
    return finals;
  }

  void reduced() {
    std::optional<TileTriangulation> t(options_);
    const Growth made = growth([&] {
      const LoadedTile tile = load(folder_ / "points.bin", o_.dimension);
      triangulate(*t, tile, KeepPoints::copied, true);
      t->take_updates();
    });
    table_.row("triangulate, reduced", made.peak, o_.points, static_cast<double>(model_.triangulate));
    const double held = static_cast<double>(t->memory());
    table_.note("  kept", made.held, o_.points);
    table_.note("  as the tile says", held, o_.points);
    const Growth asleep = growth([&] { put(folder_ / "state.bin", t->save()); });
    table_.row("sleep, above what it holds", asleep.peak, o_.points,
               model(t->memory() * budget::sleep_percent(kernel()) / 100));
    t.emplace(options_);
    const Growth awake = growth([&] {
      if (!t->load(take(folder_ / "state.bin"))) std::puts("cannot be woken");
    });
    table_.row("wake", awake.peak, o_.points, model(t->memory() * budget::wake_percent(kernel()) / 100));
    table_.note("  kept", awake.held, o_.points);
    const std::size_t before = t->memory();
    if (!t->receive(TileId{1}, foreign_)) throw std::logic_error("foreign points that no tile can have");
    t->introduce();
    table_.bound("splay, a foreign point", static_cast<double>(t->memory() - before), t->counts().inserted,
                 budget::foreign_point_bytes(o_.dimension, kernel()));
    collect(*t, load(folder_ / "points.bin", o_.dimension), true);
  }

  void whole() {
    std::optional<TileTriangulation> t(options_);
    LoadedTile tile;
    const Growth made = growth([&] {
      tile = load(folder_ / "points.bin", o_.dimension);
      triangulate(*t, tile, KeepPoints::borrowed, false);
      t->take_updates();
    });
    table_.note("triangulate, whole", made.peak, o_.points);
    table_.row("  kept", made.held, o_.points, static_cast<double>(model_.whole));
    collect(*t, std::move(tile), false);
  }

  void collect(TileTriangulation& t, LoadedTile tile, bool reduced) {
    CollectedTile collected;
    const Growth made =
        growth([&] { collected = t.collect(tile.points, tile.ids, reduced ? finals() : PendingFinals{}); });
    const double loaded = reduced ? static_cast<double>(o_.points) * 32 : 0;
    table_.row(reduced ? "collect, reduced" : "collect, whole", made.peak + loaded, o_.points,
               static_cast<double>(reduced ? model_.collect : model_.collect_whole));
    tile = {};
    const Growth stored = growth([&] {
      if (!write_tile(folder_, TileId{0}, collected.mesh, collected, {}, {})) std::puts("cannot be stored");
    });
    const double all = static_cast<double>(collected.bytes()) + stored.peak;
    table_.row("mesh, and storing it", all, o_.points, static_cast<double>(model_.mesh));
  }

  // Cells are counted and dropped; hashing them takes no memory.
  void as_points(bool reduced) {
    const budget::Needs& model = model_of_points_;
    std::optional<TileTriangulation> t(options_);
    LoadedTile tile;
    const Growth made = growth([&] {
      tile = load(folder_ / "points.bin", o_.dimension);
      t->triangulate(tile.points, tile.ids, reduced ? KeepPoints::copied : KeepPoints::borrowed);
      t->discard(tile.points, box_, !reduced, [](std::span<const Vertex>) {});
      t->announce(tile.points, box_);
      t->take_updates();
      if (reduced) tile = {};
    });
    if (reduced) {
      table_.bound("of points: triangulate, reduced", made.peak, o_.points, model.triangulate);
      table_.note("  kept", made.held, o_.points);
    } else {
      table_.note("of points: triangulate, whole", made.peak, o_.points);
      table_.bound("  kept", made.held, o_.points, model.whole);
    }
    RestOfTile rest;
    const Growth collected = growth([&] {
      if (reduced) tile = load(folder_ / "points.bin", o_.dimension);
      rest = t->collect_rest([](std::span<const Vertex>) {});
    });
    table_.row(reduced ? "of points: collect, reduced" : "of points: collect, whole", collected.peak, o_.points,
               static_cast<double>(reduced ? model.collect : model.collect_whole));
    t.reset();
    store(tile, rest);
  }

  void store(const LoadedTile& tile, const RestOfTile& rest) {
    std::vector<Point> points = tile.points;
    std::vector<PointId> ids = tile.ids;
    std::vector<TileId> owners(points.size(), TileId{0});
    for (const SharedPoint& p : rest.foreign) {
      points.push_back(p.at);
      ids.push_back(p.id);
      owners.push_back(p.tile);
    }
    const std::vector<Attribute> none;
    const PointsTileView view{o_.dimension, TileId{0}, tile.points.size(), points, ids, owners, none, {}};
    const Growth stored = growth([&] {
      if (!write_points_tile(folder_, view, {}, {})) std::puts("cannot be stored");
    });
    const auto held = static_cast<double>(points.size() * (sizeof(Point) + sizeof(PointId) + sizeof(TileId)));
    table_.row("of points: storing them", held + stored.peak, o_.points, static_cast<double>(model_of_points_.mesh));
  }

  const Options& o_;
  RoutingTable table_;
  const budget::Needs model_, model_of_points_;
  std::filesystem::path folder_;
  KnownFromStart around_;
  TileOptions options_;
  Box box_;
  Bounds beside_;
  std::vector<SharedPoint> foreign_;
};

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  using namespace tessera;
  Options o;
  CLI::App app("The memory model beside what resident memory does");
  app.add_option("--kind", o.kind, "uniform, normal, sphere, grid, terrain");
  app.add_option("-n,--points", o.points, "points");
  app.add_option("--seed", o.seed, "seed");
  app.add_option("--dim", o.dimension, "2 or 3");
  app.add_option("--folder", o.folder, "where files are written");
  app.add_flag("--cgal", o.cgal, "with CGAL's kernel");
  CLI11_PARSE(app, argc, argv);
  const auto shape = shape_named(o.kind);
  if (!shape) return 2;
  const MemoryPoolShare nothing(0);  // as a run does when memory is short
  mallopt(M_MMAP_THRESHOLD, 256 << 10);
  return Bench(o, *shape).run() ? 0 : 1;
}

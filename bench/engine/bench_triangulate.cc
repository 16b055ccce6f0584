// The whole program against CGAL alone, in one run: reads a cloud, cuts, triangulates, splays, writes; prints points/s,
// peak memory, the share of each phase, and the ratio to CGAL's sequential triangulation of the same points.
//
//   bench_triangulate --kind uniform -n 10000000 --threads 2 --tiles 16 --folder /tmp/bench
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "actors/local_run.h"
#include "bench/engine/cgal_sequential.h"
#include "src/io/cloud.h"
#include "src/io/generate.h"
#include "src/store/tile_store.h"

namespace tessera {
namespace {

struct Options {
  std::string kind = "uniform", folder = "bench-out", keep = "auto", kernel = "flat";
  std::uint64_t points = 1'000'000, seed = 7, memory_mb = 16000, tiles = 0;
  std::uint32_t threads = 2;
  int dimension = 3;
  bool cgal = true;
};

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double peak_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

Result<double> run_engine(const Options& o, const std::filesystem::path& file) {
  const std::filesystem::path out = std::filesystem::path(o.folder) / "out";
  std::filesystem::remove_all(out);  // of an earlier run, gigabytes perhaps
  const auto begin = std::chrono::steady_clock::now();
  CloudOptions cloud_options;
  cloud_options.dimension = o.dimension;
  BOOST_OUTCOME_TRY(cloud, Cloud::open({file.string()}, cloud_options));
  Progress progress;
  RouteOptions route_options;
  route_options.tiles = static_cast<std::uint32_t>(o.tiles);
  route_options.memory_bytes = o.memory_mb << 20;
  BOOST_OUTCOME_TRY(run, route(cloud, out / ".run", route_options, progress, {}));
  const double routed = seconds_since(begin);
  RunOptions run_options;
  run_options.threads = o.threads;
  run_options.memory_bytes = o.memory_mb << 20;
  run_options.keep = o.keep == "whole" ? Keep::whole : o.keep == "reduced" ? Keep::reduced : Keep::by_budget;
  run_options.kernel = o.kernel == "cgal" ? KernelKind::cgal : KernelKind::flat;
  BOOST_OUTCOME_TRY(s, run_tiles(run, out, run_options, progress, {}));
  const double collected = seconds_since(begin);
  Manifest manifest;
  manifest.dimension = o.dimension;
  manifest.partition_kind = name_of(run.partition.kind());
  manifest.boxes = run.partition.boxes();
  manifest.bounds = run.bounds;
  manifest.tiles = s.tiles;
  manifest.vertices = s.vertices;
  manifest.cells = s.cells;
  BOOST_OUTCOME_TRYV(finish_store(out, manifest, s.duplicates));
  const double total = seconds_since(begin);
  const double n = static_cast<double>(run.counts.read);
  std::printf("engine     %8.2f s  %9.0f points/s  %u threads, %zu tiles\n", total, n / total, o.threads,
              s.tiles.size());
  std::printf("  routing %.2f  triangulating %.2f  splaying %.2f  collecting %.2f  finishing %.2f s (wall)\n", routed,
              s.triangulate_s, s.splay_s, s.collect_s, total - collected);
  std::printf("  work summed over threads: triangulating %.2f  splaying %.2f  collecting %.2f s; %llu sleeps\n",
              s.triangulate_cpu_s, s.splay_cpu_s, s.collect_cpu_s, static_cast<unsigned long long>(s.sleeps));
  std::printf(
      "  splaying %.1f %% of the total; foreign points: %llu sent, %llu received, %llu inserted, %llu kept; "
      "%llu messages, %llu rounds, %llu waves\n",
      100 * s.splay_s / total, static_cast<unsigned long long>(s.points_sent),
      static_cast<unsigned long long>(s.points_received), static_cast<unsigned long long>(s.points_inserted),
      static_cast<unsigned long long>(s.points_kept), static_cast<unsigned long long>(s.batches),
      static_cast<unsigned long long>(s.rounds), static_cast<unsigned long long>(s.waves));
  std::printf("  %llu vertices, %llu cells, peak memory %.0f MiB\n", static_cast<unsigned long long>(s.vertices),
              static_cast<unsigned long long>(s.cells), peak_mb());
  return total;
}

Status run(const Options& o) {
  std::filesystem::create_directories(o.folder);
  const auto shape = shape_named(o.kind);
  if (!shape) return error(Errc::usage, "unknown kind " + o.kind);
  const auto file = std::filesystem::path(o.folder) / (o.kind + std::to_string(o.points) + ".npy");
  GenerateOptions generate_options{*shape, o.points, o.seed, o.dimension};
  BOOST_OUTCOME_TRYV(generate(generate_options, file));
  std::printf("%s, %llu points, seed %llu, %dD\n", o.kind.c_str(), static_cast<unsigned long long>(o.points),
              static_cast<unsigned long long>(o.seed), o.dimension);
  // The engine first: its peak memory is read before CGAL takes its own.
  BOOST_OUTCOME_TRY(engine, run_engine(o, file));
  if (!o.cgal) return success();
  std::vector<Point> points, batch;
  std::vector<std::uint8_t> classes;
  for (PointGenerator generator(generate_options); points.size() < o.points;) {
    generator.next(batch, classes);
    points.insert(points.end(), batch.begin(), batch.end());
  }
  const CgalTime cgal = cgal_sequential(points, o.dimension);
  std::printf("CGAL       %8.2f s  %9.0f points/s  sequential, triangulation alone, %zu cells\n", cgal.seconds,
              static_cast<double>(o.points) / cgal.seconds, cgal.cells);
  std::printf("ratio      %8.3f of CGAL's time (%.2f x)\n", engine / cgal.seconds, cgal.seconds / engine);
  return success();
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  tessera::Options o;
  CLI::App app("The whole program against CGAL's sequential triangulation");
  app.add_option("--kind", o.kind, "uniform, normal, sphere, grid, terrain");
  app.add_option("-n,--points", o.points, "points");
  app.add_option("--seed", o.seed, "seed");
  app.add_option("--threads", o.threads, "threads");
  app.add_option("--tiles", o.tiles, "tiles")->required();
  app.add_option("--memory-mb", o.memory_mb, "budget");
  app.add_option("--keep", o.keep, "auto, whole, reduced");
  app.add_option("--kernel", o.kernel, "flat, cgal");
  app.add_option("--dim", o.dimension, "2 or 3");
  app.add_option("--folder", o.folder, "where the cloud and the result go");
  app.add_flag("!--no-cgal", o.cgal, "the engine alone");
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  if (const auto done = tessera::run(o); !done) {
    std::fprintf(stderr, "%s\n", done.error().where.c_str());
    return 1;
  }
}

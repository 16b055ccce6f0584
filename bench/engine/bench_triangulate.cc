// The whole program against CGAL alone, in one run: reads a cloud, cuts, triangulates, splays, writes; prints points/s,
// peak memory, the share of each phase, and the ratio to CGAL's sequential triangulation of the same points.
//
//   bench_triangulate --kind uniform -n 10000000 --threads 2 --tiles 16 --folder /tmp/bench
#include <CLI/CLI.hpp>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>

#include "bench/engine/cgal_sequential.h"
#include "src/base/option.h"
#include "src/base/phases.h"
#include "src/input/generate/generate.h"
#include "src/job/job.h"
#include "src/job/open_cloud.h"
#include "src/result/tile_source.h"

namespace tessera {
namespace {

struct Options {
  std::string kind = "uniform", folder = "bench-out", keep = "auto", kernel = "flat";
  std::uint64_t points = 1'000'000, seed = 7, memory_mb = 16000, tiles = 0;
  std::uint32_t threads = 2;
  int dimension = 3;
  bool cgal = true;
};

// Processor time of the digests, measured again on the stored tiles.
Result<double> digest_seconds(const std::filesystem::path& out) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out));
  std::clock_t total = 0;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    BOOST_OUTCOME_TRY(tile, source.read(i, {}));
    const std::clock_t begin = std::clock();
    const Digest digest = digest_of(tile.mesh);
    total += std::clock() - begin;
    if (digest != source.entry(i).digest)
      return error(Errc::internal, "a tile's digest is not the one in the manifest");
  }
  return static_cast<double>(total) / CLOCKS_PER_SEC;
}

Result<double> run_engine(const Options& o, const std::filesystem::path& file) {
  const std::filesystem::path out = std::filesystem::path(o.folder) / "out";
  std::filesystem::remove_all(out);  // of an earlier run, gigabytes perhaps
  JobOptions options;
  options.cloud.dimension = o.dimension;
  options.tiles = static_cast<std::uint32_t>(o.tiles);
  options.threads = o.threads;
  options.memory_bytes = o.memory_mb << 20;
  options.keep = o.keep == "whole"     ? TileRetention::whole
                 : o.keep == "reduced" ? TileRetention::reduced
                                       : TileRetention::by_budget;
  options.kernel = o.kernel == "cgal" ? KernelKind::cgal : KernelKind::flat;
  BOOST_OUTCOME_TRY(folder, ResultFolder::inspect(out, false, false));
  Progress progress;
  const auto open = [&](JobOptions& job, const std::stop_token& stop) {
    return open_cloud({file.string()}, job, stop);
  };
  Engine engine(options.threads, options.memory_bytes);
  const std::clock_t begin = std::clock();
  BOOST_OUTCOME_TRY(done, run_job(engine, options, open, folder, progress, {}));
  const double work_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const JobSummary& s = *done;
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));  // has the times that were summed over threads
  const std::string exchange = name_of(phase_of(ProgramKind::delaunay, StageStep::exchange));
  std::printf("engine     %8.2f s  %9.0f points/s  %u threads, %llu tiles\n", s.total_s,
              static_cast<double>(s.points_read) / s.total_s, o.threads, static_cast<unsigned long long>(s.tiles));
  for (const auto& [name, seconds] : s.seconds) std::printf("  %s %.2f", name.c_str(), seconds);
  std::printf(" s (wall)\n  work summed over threads:");
  for (const auto& [name, wall_s] : s.seconds) {
    const auto cpu = manifest.figures.find(name + "_cpu_s");
    if (cpu != manifest.figures.end()) std::printf(" %s %.2f ", name.c_str(), cpu->second);
  }
  std::printf("s; %llu sleeps\n", static_cast<unsigned long long>(s.exchange.sleeps));
  std::printf(
      "  %s %.1f %% of the total; foreign points: %llu sent, %llu received, %llu inserted, %llu kept; "
      "%llu messages, %llu rounds, %llu waves; at most %llu to one tile\n",
      exchange.c_str(), 100 * manifest.seconds[exchange] / s.total_s,
      static_cast<unsigned long long>(s.exchange.points.sent),
      static_cast<unsigned long long>(s.exchange.points.received),
      static_cast<unsigned long long>(s.exchange.points.inserted),
      static_cast<unsigned long long>(s.exchange.points.useful), static_cast<unsigned long long>(s.exchange.updates),
      static_cast<unsigned long long>(s.exchange.hops), static_cast<unsigned long long>(s.exchange.waves),
      static_cast<unsigned long long>(s.exchange.most_received));
  std::printf("  %llu vertices, %llu cells, peak memory %.0f MiB\n", static_cast<unsigned long long>(s.vertices),
              static_cast<unsigned long long>(s.cells), static_cast<double>(s.peak_memory_bytes) / (1 << 20));
  BOOST_OUTCOME_TRY(digest_s, digest_seconds(out));
  std::printf("  digest %s: %.3f s of %.2f s of processor time\n", s.digest.c_str(), digest_s, work_s);
  return s.total_s;
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
    std::fprintf(stderr, "%s\n", tessera::in_plain_words(done.error().where).c_str());
    return 1;
  }
}

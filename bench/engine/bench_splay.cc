// The exchange alone, on one thread and without messages: all tiles are triangulated, then each in turn processes what
// has come for it until nothing is left. Tells what a foreign point costs.
//
//   bench_splay --kind uniform -n 8000000 --tiles 8 --folder /tmp/bench
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/option.h"
#include "src/generate/generate.h"
#include "src/io/cloud/cloud.h"
#include "src/run/disk_storage.h"
#include "src/run/tile_state.h"
#include "src/run/touching.h"
#include "src/tiling/routed_run.h"

namespace tessera {
namespace {

struct Options {
  std::string kind = "uniform", folder = "bench-out";
  std::uint64_t points = 1'000'000, seed = 7, tiles = 8;
  int dimension = 3;
};

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

Status run(const Options& o, CloudShape shape) {
  const std::filesystem::path file = std::filesystem::path(o.folder) / "cloud.npy";
  BOOST_OUTCOME_TRYV(generate({shape, o.points, o.seed, o.dimension}, file));
  CloudOptions cloud_options;
  cloud_options.dimension = o.dimension;
  BOOST_OUTCOME_TRY(cloud, Cloud::open({file.string()}, cloud_options));
  Progress progress;
  RouteOptions route_options;
  route_options.tiles = static_cast<std::uint32_t>(o.tiles);
  const std::filesystem::path out = std::filesystem::path(o.folder) / "out";
  std::filesystem::remove_all(out);
  BOOST_OUTCOME_TRY(routed_run, route(cloud, run_folder(out), route_options, progress, {}));
  const auto run = std::make_shared<const RoutedRun>(std::move(routed_run));
  const RoutedRun& routed = *run;
  DiskStorage storage(run, out, {}, 1);
  TileContext context;
  context.dimension = o.dimension;
  context.boxes = final_boxes(routed.partition);
  context.neighbours = touching_tiles(routed.partition, routed.tile_bounds);
  context.seeds = routed.seeds;
  context.storage = &storage;

  std::vector<std::unique_ptr<TileState>> tiles;
  double triangulating = 0, splaying = 0;
  const auto post = [&](TileState& from) -> Status {
    for (Batch& batch : from.take_outgoing()) {
      BOOST_OUTCOME_TRYV(tiles[batch.to.tile.value]->receive(std::move(batch)));
    }
    return success();
  };
  for (std::uint32_t t = 0; t < routed.tile_points.size(); ++t) {
    tiles.push_back(std::make_unique<TileState>(Peer{TileId{t}, 0}, context));
  }
  for (auto& tile : tiles) {
    const auto begin = Clock::now();
    BOOST_OUTCOME_TRYV(tile->begin());
    triangulating += seconds_since(begin);
  }
  for (auto& tile : tiles) {
    BOOST_OUTCOME_TRYV(post(*tile));
  }
  bool quiet = false;
  int rounds = 0;
  for (; !quiet; ++rounds) {
    quiet = true;
    for (auto& tile : tiles) {
      if (tile->waiting_points() == 0) continue;
      quiet = false;
      const auto begin = Clock::now();
      BOOST_OUTCOME_TRYV(tile->splay());
      splaying += seconds_since(begin);
      BOOST_OUTCOME_TRYV(post(*tile));
    }
  }
  ExchangeCounts sum;
  for (const auto& tile : tiles) {
    sum += tile->counts();
  }
  std::printf("%s, %llu points, seed %llu, %dD, %llu tiles, one thread\n", o.kind.c_str(),
              static_cast<unsigned long long>(o.points), static_cast<unsigned long long>(o.seed), o.dimension,
              static_cast<unsigned long long>(o.tiles));
  std::printf("triangulating %.3f s  %.2f us a point\n", triangulating,
              triangulating * 1e6 / static_cast<double>(o.points));
  std::printf("splaying      %.3f s  %.2f us a point received, %d rounds, %.1f %% of triangulating\n", splaying,
              splaying * 1e6 / static_cast<double>(sum.received), rounds, 100 * splaying / triangulating);
  std::printf("%llu sent, %llu received, %llu inserted, %llu refused\n", static_cast<unsigned long long>(sum.sent),
              static_cast<unsigned long long>(sum.received), static_cast<unsigned long long>(sum.inserted),
              static_cast<unsigned long long>(sum.refused));
  return success();
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  tessera::Options o;
  CLI::App app("The exchange alone, on one thread");
  app.add_option("--kind", o.kind, "uniform, normal, sphere, grid, terrain");
  app.add_option("-n,--points", o.points, "points");
  app.add_option("--seed", o.seed, "seed");
  app.add_option("--dim", o.dimension, "2 or 3");
  app.add_option("--tiles", o.tiles, "tiles");
  app.add_option("--folder", o.folder, "for the cloud and the run");
  CLI11_PARSE(app, argc, argv);
  const auto shape = tessera::shape_named(o.kind);
  if (!shape) return 2;
  std::filesystem::create_directories(o.folder);
  const auto done = tessera::run(o, *shape);
  if (!done) std::fprintf(stderr, "bench_splay: %s\n", tessera::in_plain_words(done.error().where).c_str());
  return done ? 0 : 1;
}

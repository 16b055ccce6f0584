#include "actors/local_run.h"

#include <malloc.h>

#include <algorithm>
#include <caf/all.hpp>
#include <chrono>
#include <utility>

#include "actors/coordinator.h"
#include "actors/disk_storage.h"
#include "actors/node_actor.h"
#include "actors/run_log.h"
#include "actors/tile_actor.h"
#include "actors/touching.h"
#include "src/base/memory_pool.h"

namespace tessera {
namespace {

// Bytes a point, measured on uniform and terrain points (bench/engine/bench_tile): the whole triangulation in memory;
// building it and taking it apart; collecting a mesh on top of what is held; the mesh that is stored.
struct Needs {
  std::uint64_t whole, triangulate, collect, mesh;
};
Needs needs(int dimension, KernelKind kernel) {
  if (kernel == KernelKind::cgal) return dimension == 3 ? Needs{620, 900, 560, 270} : Needs{240, 340, 160, 100};
  return dimension == 3 ? Needs{300, 700, 700, 270} : Needs{130, 260, 240, 100};
}

// What is left for tiles: libraries, buffers and the allocator's slack take the rest.
std::uint64_t tile_budget(std::uint64_t memory) {
  const std::uint64_t rest = memory / 10 + (std::uint64_t{64} << 20);
  return memory > 2 * rest ? memory - rest : memory / 2;
}

// All tiles whole in memory, every thread collecting one and another one on its way to the store.
bool fits_whole(const RoutedRun& run, const RunOptions& options) {
  const Needs need = needs(run.dimension, options.kernel);
  std::uint64_t points = 0, largest = 0;
  for (const std::uint64_t n : run.tile_points) {
    points += n;
    largest = std::max(largest, n);
  }
  return points * need.whole + options.threads * largest * (need.collect + need.mesh) <=
         tile_budget(options.memory_bytes);
}

class LocalConfig : public caf::actor_system_config {
 public:
  explicit LocalConfig(std::uint32_t threads) {
    add_message_types<caf::id_block::tessera>();
    set("scheduler.max-threads", static_cast<std::size_t>(threads));
    set("scheduler.policy", caf::atom("sharing"));
  }
};

}  // namespace

Result<RunSummary> run_tiles(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                             Progress& progress, std::stop_token stop) {
  BOOST_OUTCOME_TRY(stored, stored_tiles(out));
  DiskStorage storage(run, out, options.store, options.threads);
  TileContext context;
  context.dimension = run.dimension;
  context.kernel = options.kernel;
  context.reduce = options.keep == Keep::reduced || (options.keep == Keep::by_budget && !fits_whole(run, options));
  // When memory is short, large blocks go straight back to the system instead of into the allocator's pools.
  if (context.reduce) mallopt(M_MMAP_THRESHOLD, 256 << 10);
  // So do the kernels' arrays: a pool would hold pages that no tile's account shows.
  limit_memory_pool(context.reduce ? 0 : options.memory_bytes / 4);
  context.boxes = final_boxes(run.partition);
  context.neighbours = touching_tiles(run.partition, run.tile_bounds);
  context.seeds = run.seeds;
  context.storage = &storage;
  context.progress = &progress;

  progress.tiles_total = static_cast<std::uint32_t>(
      std::count_if(run.tile_points.begin(), run.tile_points.end(), [](auto n) { return n > 0; }));
  const Needs need = needs(run.dimension, options.kernel);
  NodeOptions node_options;
  node_options.threads = options.threads;
  node_options.memory_bytes = tile_budget(options.memory_bytes);
  node_options.triangulate_bytes = need.triangulate;
  node_options.collect_bytes = need.collect;
  node_options.points = run.tile_points;
  node_options.stored = std::move(stored);
  node_options.stop = stop;

  RunLog log;
  RunEnded ended;
  double quiet_s = 0;
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  {
    LocalConfig config(options.threads);
    Directory directory;  // dies after the system: actors refer to it
    caf::actor_system system(config);
    caf::scoped_actor self(system);
    const auto coordinator = self->spawn<Coordinator>(caf::actor_cast<caf::actor>(self.ptr()), 1u);
    directory.tiles.resize(run.tile_points.size());
    for (std::uint32_t t = 0; t < run.tile_points.size(); ++t) {
      if (run.tile_points[t] == 0) continue;
      directory.tiles[t] = self->spawn<TileActor>(Peer{TileId{t}, 0}, std::cref(context), std::cref(directory));
    }
    directory.node =
        self->spawn<NodeActor>(std::cref(node_options), std::cref(directory), std::ref(log), coordinator, &progress);
    self->send(coordinator, std::vector<caf::actor>{directory.node});
    bool running = true;
    self->receive_while(running)([&](const RunQuiet&) { quiet_s = elapsed(); },
                                 [&](RunEnded& message) {
                                   ended = std::move(message);
                                   running = false;
                                 });
    for (const auto& tile : directory.tiles) {
      if (tile) caf::anon_send_exit(tile, caf::exit_reason::user_shutdown);
    }
    caf::anon_send_exit(directory.node, caf::exit_reason::user_shutdown);
    caf::anon_send_exit(coordinator, caf::exit_reason::user_shutdown);
    self->await_all_other_actors_done();
    directory = {};
  }
  if (ended.code != 0) return error(static_cast<Errc>(ended.code), ended.text);

  RunSummary summary = std::move(log.summary);
  summary.waves = ended.waves;
  for (const auto& tile : log.tiles) {
    summary.batches += tile.batches;
    summary.points_sent += tile.points_sent;
    summary.points_received += tile.received;
    summary.points_inserted += tile.inserted;
    summary.points_kept += tile.kept;
  }
  std::sort(summary.tiles.begin(), summary.tiles.end(), [](auto& a, auto& b) { return a.tile < b.tile; });
  std::sort(summary.duplicates.begin(), summary.duplicates.end());
  for (const TileEntry& tile : summary.tiles) summary.cells += tile.main_cells;
  summary.triangulate_s = log.triangulated_s;
  summary.splay_s = quiet_s - log.triangulated_s;
  summary.collect_s = elapsed() - quiet_s;
  return summary;
}

}  // namespace tessera

// Runs the tiles of a routed cloud as actors on this machine until message counting proves quiet, and stores them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/kernel/kernel.h"
#include "src/store/tile_store.h"
#include "src/tiling/routed_run.h"

namespace tessera {

// Whether tiles keep their whole triangulation in memory, or hand out final cells and keep the rest.
enum class Keep : std::uint8_t { by_budget, whole, reduced };

struct RunOptions {
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;
  KernelKind kernel = KernelKind::flat;
  Keep keep = Keep::by_budget;
  StoreOptions store;
};

struct RunSummary {
  std::vector<TileEntry> tiles;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> duplicates;  // ascending
  std::uint64_t vertices = 0, cells = 0;
  std::uint64_t batches = 0, points_sent = 0, points_received = 0, points_inserted = 0, points_kept = 0;
  std::uint64_t rounds = 0;  // the longest chain of messages that caused one another: rounds equivalent
  std::uint64_t waves = 0;   // collections of counters by the coordinator
  std::uint64_t sleeps = 0;
  std::vector<double> tile_seconds;                                  // by tile: time worked on it
  double triangulate_s = 0, splay_s = 0, collect_s = 0;              // wall clock of the phases
  double triangulate_cpu_s = 0, splay_cpu_s = 0, collect_cpu_s = 0;  // summed over threads
};

// Error interrupted when `stop` was requested: what is stored stays for --resume.
Result<RunSummary> run_tiles(const RoutedRun& run, const std::filesystem::path& out, const RunOptions& options,
                             Progress& progress, std::stop_token stop);

}  // namespace tessera

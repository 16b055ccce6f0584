// The real actors under CAF's deterministic scheduler: every seed is another interleaving, and the same seed the same
// one. Each run is compared with CGAL's triangulation of the whole cloud.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "src/tiling/partition.h"

namespace tessera {

struct HarnessOptions {
  std::string kind = "uniform";  // src/harness/clouds.h
  int dimension = 3;
  std::size_t points = 40;
  std::uint32_t tiles = 7;
  PartitionKind partition = PartitionKind::kdtree;
  std::uint64_t first_seed = 1, last_seed = 1;    // inclusive
  std::function<void(const std::string&)> trace;  // hears of every step
};

struct HarnessReport {
  std::uint64_t seeds = 0;  // that passed
  std::uint64_t steps = 0;  // messages handled
  std::uint64_t batches = 0, waves = 0, sleeps = 0;
  // The first seed whose run was wrong, and how: cells that differ, quiescence believed too early, or no end.
  std::optional<std::uint64_t> failed_seed;
  std::string failure;
};

// The seed decides cloud, schedule, delays, the number of grants under way, the memory budget (some force every tile to
// sleep after each step, some a part of them) and whether tiles are reduced.
HarnessReport run_harness(const HarnessOptions& options);

}  // namespace tessera

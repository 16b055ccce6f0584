// What running the tiles of a job has made.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/figures.h"
#include "src/result/store/tile_store.h"

namespace tessera {

struct RunSummary {
  std::vector<TileEntry> tiles;      // ascending
  std::vector<double> tile_seconds;  // beside them: worked on each
  std::uint64_t vertices = 0, cells = 0;
  ExchangeFigures exchange;
  std::uint64_t memory_bytes = 0;  // that all nodes which had a part gave the job
  StepSeconds wall;                // wall clock
};

}  // namespace tessera

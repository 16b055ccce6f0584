// What the run of a job's tiles has made.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/figures.h"
#include "src/result/store/tile_store.h"

namespace tessera {

struct RunSummary {
  std::vector<TileEntry> tiles;      // ascending
  std::vector<double> tile_seconds;  // beside tiles: time that threads worked on each
  std::uint64_t vertices = 0, cells = 0;
  ExchangeFigures exchange;
  std::uint64_t memory_bytes = 0;  // what all nodes with a share gave to the job
  StepSeconds wall;                // wall clock
};

}  // namespace tessera

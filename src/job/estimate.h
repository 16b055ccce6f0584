// What a job will take: pure functions of the cloud's size and the machine.
#pragma once

#include <cstdint>
#include <vector>

#include "src/geometry/kernel/kernel.h"
#include "src/input/reader.h"
#include "src/tiling/budget/budget.h"

namespace tessera {

// Returns the number of points of a cloud, from the headers of its files, or from the file's size where a header has
// none.
std::uint64_t expected_points(const std::vector<FileInfo>& files);

struct Machine {
  std::uint64_t memory_bytes = 0;  // that the job may use
  std::uint32_t threads = 1;
};

struct Estimate {
  std::uint64_t cells = 0;
  std::uint64_t memory_bytes = 0;     // resident, at most Machine::memory_bytes
  budget::Phases phases;              // the same by phase
  std::uint64_t result_bytes = 0;     // of the result folder
  std::uint64_t temporary_bytes = 0;  // of the run folder, removed at the end
  double seconds = 0;
};
// `kind`: of the tiles of the result. `tile_limit`: points that a tile has at most.
Estimate estimate(int dimension, KernelKind kernel, TileKind kind, std::uint64_t points, std::uint64_t tile_limit,
                  bool neighbors, std::uint64_t attribute_row_bytes, const Machine& machine);

}  // namespace tessera

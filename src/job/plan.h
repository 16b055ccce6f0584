// How large tiles should be, and what a job will cost: pure functions of the cloud's size and the machine.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/result.h"
#include "src/io/reader.h"

namespace tessera {

// The number of points of a cloud as its headers tell it; where they do not, as the size of the file suggests.
std::uint64_t expected_points(const std::vector<FileInfo>& files);

struct Machine {
  std::uint64_t memory_bytes = 0;  // that the job may use
  std::uint32_t threads = 1;
};

// Points a tile should hold at most: what fits while every thread works on a tile and the mail of others waits, but
// small enough that all threads have several tiles to work on. Error memory when even a small tile would not fit.
Result<std::uint64_t> choose_tile_limit(int dimension, std::uint64_t points, const Machine& machine);

// Error memory when a tile of `points` cannot be triangulated within the memory, whatever else waits on disk.
Status check_tile_fits(int dimension, std::uint64_t points, std::uint64_t memory_bytes);

struct Estimate {
  std::uint64_t cells = 0;
  std::uint64_t memory_bytes = 0;     // resident, at most the budget
  std::uint64_t result_bytes = 0;     // of the result folder
  std::uint64_t temporary_bytes = 0;  // of the run folder, gone at the end
  double seconds = 0;
};
Estimate estimate(int dimension, std::uint64_t points, std::uint64_t tile_limit, bool neighbors,
                  std::uint64_t attribute_row_bytes, const Machine& machine);

}  // namespace tessera

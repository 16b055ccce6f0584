#include "src/job/estimate.h"

#include <algorithm>
#include <cmath>

#include "src/tiling/budget/budget.h"

#include "src/base/option.h"

namespace tessera {

std::uint64_t expected_points(const std::vector<FileInfo>& files) {
  std::uint64_t points = 0;
  for (const auto& file : files) {
    // 28 bytes a point: three numbers of eight digits and their separators. Only text files do not tell their points.
    points += file.points ? *file.points : file.content_bytes / 28;
  }
  return points;
}

Estimate estimate(int dimension, KernelKind kernel, TileKind kind, std::uint64_t points, std::uint64_t tile_limit,
                  bool neighbors, std::uint64_t attribute_row_bytes, const Machine& machine) {
  const auto n = static_cast<double>(points);
  const double tiles = std::max(1.0, n / static_cast<double>(std::max<std::uint64_t>(1, tile_limit)));
  // The fraction of stars that two tiles share, if tiles are cubes: the layer of points along a tile's six (four)
  // sides.
  const double side = std::pow(static_cast<double>(std::min(points, tile_limit)), 1.0 / dimension);
  const double shared = tiles < 2 ? 0 : std::min(1.0, 2.0 * dimension / std::max(1.0, side));
  const double cells_a_point = dimension == 3 ? 6.75 : 2.0;
  const bool with_cells = kind == TileKind::cells;
  const double cell_bytes = with_cells ? 4.0 * (dimension + 1) * (neighbors ? 2 : 1) + 1 : 0;
  // Packed coordinates and ids of points that differ as much as points can; attributes may differ as much, too.
  const double vertex_bytes = (with_cells ? 24 + 8 + 1 : 8.0 * dimension) + static_cast<double>(attribute_row_bytes);
  const double points_a_second = dimension == 3 ? 330'000 : 800'000;  // a thread, from input file to result on disk

  Estimate estimate;
  estimate.cells = static_cast<std::uint64_t>(cells_a_point * n);
  estimate.phases = budget::phases(dimension, kernel, kind, points, tile_limit, machine.threads, machine.memory_bytes);
  for (const auto& [phase, bytes] : estimate.phases.bytes)
    estimate.memory_bytes = std::max(estimate.memory_bytes, bytes);
  estimate.result_bytes = static_cast<std::uint64_t>(n * (1 + shared) * (cells_a_point * cell_bytes + vertex_bytes));
  estimate.temporary_bytes = points * (sizeof(double) * 4 + attribute_row_bytes);
  if (with_cells && !estimate.phases.whole) {  // final cells wait on disk, with their neighbours
    estimate.temporary_bytes += static_cast<std::uint64_t>(n * cells_a_point * 8 * (dimension + 1));
  }
  estimate.seconds = n * (1 + shared) / (points_a_second * std::min<double>(machine.threads, tiles));
  return estimate;
}

}  // namespace tessera

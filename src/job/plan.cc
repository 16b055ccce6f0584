#include "src/job/plan.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace tessera {
namespace {

// Bytes a point of a tile costs while the tile is worked on, its kernel, mesh and buffers included.
constexpr std::uint64_t point_bytes(int dimension) { return dimension == 3 ? 700 : 260; }
constexpr std::uint64_t smallest_tile = 10'000;
// Above this a tile gains nothing: its stars at the border are under 3 % of it already.
constexpr std::uint64_t largest_tile(int dimension) { return dimension == 3 ? 1'000'000 : 2'000'000; }
// Below this, halving tiles to keep threads busy costs more in stars at borders than it gains.
constexpr std::uint64_t worthwhile_tile = 200'000;

std::string in_mebibytes(double bytes) {
  return std::to_string(static_cast<std::uint64_t>(bytes / (1 << 20)) + 1) + "M";
}

}  // namespace

std::uint64_t expected_points(const std::vector<FileInfo>& files) {
  std::uint64_t points = 0;
  for (const auto& file : files) {
    // 28 bytes a point: three numbers of eight digits and their separators. Only text leaves it open.
    points += file.points ? *file.points : file.bytes / 28;
  }
  return points;
}

Result<std::uint64_t> choose_tile_limit(int dimension, std::uint64_t points, const Machine& machine) {
  const auto fitting = static_cast<std::uint64_t>(0.45 * static_cast<double>(machine.memory_bytes) /
                                                  static_cast<double>(machine.threads * point_bytes(dimension)));
  // A cloud smaller than the smallest tile is one tile, and needs no more than it.
  const auto needed = std::clamp<std::uint64_t>(points, 100, smallest_tile);
  if (fitting < needed) {
    const double wanted = static_cast<double>(needed * machine.threads * point_bytes(dimension)) / 0.45;
    return error(Errc::memory, "--memory is too small for " + std::to_string(machine.threads) +
                                   (machine.threads == 1 ? " thread" : " threads") + " with tiles of even " +
                                   std::to_string(needed) + " points each; give at least " + in_mebibytes(wanted) +
                                   (machine.threads == 1 ? "" : ", or fewer --threads"));
  }
  const std::uint64_t busy = std::max(worthwhile_tile, points / (4 * machine.threads) + 1);
  return std::min({std::max(fitting, needed), largest_tile(dimension), busy});
}

Status check_tile_fits(int dimension, std::uint64_t points, std::uint64_t memory_bytes) {
  if (points <= memory_bytes / point_bytes(dimension)) return success();
  return error(Errc::memory,
               "a tile of " + std::to_string(points) + " points needs about " +
                   in_mebibytes(static_cast<double>(points) * static_cast<double>(point_bytes(dimension))) +
                   " of memory, which --memory does not allow; ask for smaller tiles");
}

Estimate estimate(int dimension, std::uint64_t points, std::uint64_t tile_limit, bool neighbors,
                  std::uint64_t attribute_row_bytes, const Machine& machine) {
  const auto n = static_cast<double>(points);
  const double tiles = std::max(1.0, n / static_cast<double>(std::max<std::uint64_t>(1, tile_limit)));
  // Stars that two tiles share, for tiles as cubes: the layer of points along a tile's six (four) sides.
  const double side = std::pow(static_cast<double>(std::min(points, tile_limit)), 1.0 / dimension);
  const double shared = tiles < 2 ? 0 : std::min(1.0, 2.0 * dimension / std::max(1.0, side));
  const double cells_a_point = dimension == 3 ? 6.75 : 2.0;
  const double cell_bytes = 4.0 * (dimension + 1) * (neighbors ? 2 : 1) + 1;
  const double vertex_bytes = 24 + 8 + 1 + static_cast<double>(attribute_row_bytes);
  const double points_a_second = dimension == 3 ? 330'000 : 800'000;  // a thread, from input file to result on disk

  Estimate estimate;
  estimate.cells = static_cast<std::uint64_t>(cells_a_point * n);
  // Tiles stay in memory while the budget lasts, and sleep on disk beyond it.
  const double working = static_cast<double>(point_bytes(dimension)) * n;
  estimate.memory_bytes =
      std::min(machine.memory_bytes, static_cast<std::uint64_t>(working) + (std::uint64_t{64} << 20));
  estimate.result_bytes = static_cast<std::uint64_t>(n * (1 + shared) * (cells_a_point * cell_bytes + vertex_bytes));
  estimate.temporary_bytes = points * (sizeof(double) * 4 + attribute_row_bytes);
  if (working > static_cast<double>(machine.memory_bytes)) {  // final cells wait on disk, with their neighbours
    estimate.temporary_bytes += static_cast<std::uint64_t>(n * cells_a_point * 8 * (dimension + 1));
  }
  estimate.seconds = n * (1 + shared) / (points_a_second * std::min<double>(machine.threads, tiles));
  return estimate;
}

}  // namespace tessera

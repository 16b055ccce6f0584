// How large tiles may be.
#include <algorithm>
#include <string>

#include "src/base/option.h"
#include "src/budget/budget.h"

namespace tessera::budget {
namespace {

constexpr std::uint64_t mib = std::uint64_t{1} << 20;
constexpr std::uint64_t smallest_tile = 10'000;
// Above this a tile gains nothing: its stars at the border are under 3 % of it already.
constexpr std::uint64_t largest_tile(int dimension) { return dimension == 3 ? 1'000'000 : 2'000'000; }
// Below this, halving tiles to keep threads busy costs more in stars at borders than it gains.
constexpr std::uint64_t worthwhile_tile = 200'000;

std::string in_mebibytes(std::uint64_t bytes) { return std::to_string((bytes + mib - 1) / mib) + "M"; }

std::string threads_text(std::uint32_t threads) {
  return std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

// A point of a tile while it is triangulated, or while it is collected: its mesh is stored when another one is made.
std::uint64_t largest_need(int dimension, KernelKind kernel) {
  const Needs need = needs(dimension, kernel);
  return std::max(need.triangulate, need.image + need.collect);
}

// Points a tile may have so that every thread works on one and there is as much room for tiles that are awake.
std::uint64_t fitting(int dimension, KernelKind kernel, std::uint32_t threads, std::uint64_t memory_bytes) {
  return for_tiles(memory_bytes, threads) / 2 / (std::max(1u, threads) * largest_need(dimension, kernel));
}

}  // namespace

std::uint64_t least_memory(int dimension, KernelKind kernel, std::uint64_t tile_points, std::uint32_t threads) {
  const std::uint64_t tiles = 2 * tile_points * std::max(1u, threads) * largest_need(dimension, kernel);
  std::uint64_t bytes = (fixed_bytes(threads) + tiles / 7 * 8) / mib * mib;
  while (fitting(dimension, kernel, threads, bytes) < tile_points) bytes += mib;  // rounding, a step or two
  return bytes;
}

Result<std::uint64_t> tile_limit(int dimension, KernelKind kernel, std::uint64_t points, std::uint32_t threads,
                                 std::uint64_t memory_bytes) {
  // A cloud smaller than the smallest tile is one tile, and needs no more than it.
  const auto needed = std::clamp<std::uint64_t>(points, 100, smallest_tile);
  if (memory_bytes < least_memory(dimension, kernel, needed, threads)) {
    return error(Errc::memory, option("memory") + " is too small for " + threads_text(threads) +
                                   " with tiles of even " + std::to_string(needed) + " points each; give at least " +
                                   in_mebibytes(least_memory(dimension, kernel, needed, threads)) +
                                   (threads == 1 ? "" : ", or fewer " + option("threads")));
  }
  const std::uint64_t busy = std::max(worthwhile_tile, points / (4 * threads) + 1);
  const std::uint64_t fits = fitting(dimension, kernel, threads, memory_bytes);
  return std::min({std::max(fits, needed), largest_tile(dimension), busy});
}

Status tile_fits(int dimension, KernelKind kernel, std::uint64_t points, std::uint32_t threads,
                 std::uint64_t memory_bytes) {
  // One at a time may be worked on while all others sleep: the threads wait for it.
  const std::uint64_t tiles = points * largest_need(dimension, kernel);
  if (tiles <= for_tiles(memory_bytes, threads) && memory_bytes >= least_memory(dimension, kernel, 100, threads))
    return success();
  const std::uint64_t least =
      std::max(fixed_bytes(threads) + tiles / 7 * 8 + 7, least_memory(dimension, kernel, 100, threads));
  return error(Errc::memory, "a tile of " + std::to_string(points) + " points needs about " + in_mebibytes(tiles) +
                                 " of memory, which " + option("memory") +
                                 " does not allow; ask for smaller tiles, or give at least " + in_mebibytes(least));
}

}  // namespace tessera::budget

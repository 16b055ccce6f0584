// How large tiles may be.
#include <algorithm>
#include <string>

#include "src/base/option.h"
#include "src/tiling/budget/budget.h"

namespace tessera::budget {
namespace {

constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20;
constexpr std::uint64_t smallest_tile = 10'000;
// A larger tile gains nothing: less than 3 % of its stars are at its border.
constexpr std::uint64_t largest_tile(int dimension) { return dimension == 3 ? 1'000'000 : 2'000'000; }
// Below this, halving tiles to keep threads busy costs more in stars at borders than it gains.
constexpr std::uint64_t worthwhile_tile = 200'000;

std::string in_mebibytes(std::uint64_t bytes) { return std::to_string((bytes + mebibyte - 1) / mebibyte) + "M"; }

std::string threads_text(std::uint32_t threads) {
  return std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

// Bytes per point of a tile while it is triangulated, or while it is collected: its mesh is stored while another one is
// made.
std::uint64_t largest_need(int dimension, KernelKind kernel) {
  const Needs need = needs(dimension, kernel);
  return std::max(need.triangulate, need.image + need.collect);
}

// As for_tiles(), but 0 when nothing is left.
std::uint64_t left_for_tiles(std::uint64_t memory_bytes, std::uint32_t threads, std::uint64_t tiles) {
  const std::uint64_t taken = fixed_bytes(threads) + tiles * tile_bytes;
  return memory_bytes > taken ? std::min((memory_bytes - taken) / 8 * 7, for_tiles(memory_bytes, threads, tiles)) : 0;
}

// Returns how many points a tile may have so that every thread works on a tile, and a quarter of the memory is free for
// other tiles that are awake. A quarter is enough: larger tiles have fewer stars at borders, and more memory for awake
// tiles would spare only few sleeps. Returns 0 when there are too many tiles, however large they are. The larger the
// tiles, the fewer there are. So the size that fits beside 0 tiles is an upper bound, and the size that fits beside the
// tiles of an upper bound is one, too.
std::uint64_t fitting(int dimension, KernelKind kernel, std::uint64_t points, std::uint32_t threads,
                      std::uint64_t memory_bytes) {
  const auto fits = [&](std::uint64_t tiles) {
    return left_for_tiles(memory_bytes, threads, tiles) / 4 * 3 /
           (std::max(1u, threads) * largest_need(dimension, kernel));
  };
  std::uint64_t bound = fits(0);
  while (bound > 0) {
    const std::uint64_t next = fits(points / bound + 1);
    if (next >= bound) break;
    bound = std::min(next, bound - bound / 64 - 1);
  }
  return bound;
}

// Returns the least number of whole MiB for which `holds` is true. REQUIRES: it is true for all larger numbers, too.
template <class Holds>
std::uint64_t least_memory(Holds holds) {
  std::uint64_t below = 0, above = mebibyte;
  while (!holds(above)) {
    below = above;
    above *= 2;
  }
  while (above - below > mebibyte) {
    const std::uint64_t middle = (below + above) / 2 / mebibyte * mebibyte;
    (holds(middle) ? above : below) = middle;
  }
  return above;
}

}  // namespace

Result<std::uint64_t> tile_limit(int dimension, KernelKind kernel, std::uint64_t points, std::uint32_t threads,
                                 std::uint64_t memory_bytes) {
  // A cloud smaller than the smallest tile is one tile, and needs no more memory than that.
  const auto needed = std::clamp<std::uint64_t>(points, 100, smallest_tile);
  const auto enough = [&](std::uint64_t bytes) { return fitting(dimension, kernel, points, threads, bytes) >= needed; };
  if (!enough(memory_bytes)) {
    return error(Errc::memory, option("memory") + " is too small for " + threads_text(threads) +
                                   " with tiles of even " + std::to_string(needed) + " points each; give at least " +
                                   in_mebibytes(least_memory(enough)) +
                                   (threads == 1 ? "" : ", or fewer " + option("threads")));
  }
  const std::uint64_t busy = std::max(worthwhile_tile, points / (4 * threads) + 1);
  return std::min({fitting(dimension, kernel, points, threads, memory_bytes), largest_tile(dimension), busy});
}

std::uint64_t tile_working_bytes(int dimension, KernelKind kernel, std::uint64_t points) {
  return points * largest_need(dimension, kernel);
}

std::uint64_t tile_points_max(int dimension, KernelKind kernel, std::uint32_t threads, std::uint64_t memory_bytes) {
  return left_for_tiles(memory_bytes - outbox_bytes(memory_bytes), threads, 1) / largest_need(dimension, kernel);
}

std::uint64_t tile_points_max(int dimension, KernelKind kernel, std::span<const NodeShare> nodes) {
  std::uint64_t most = 0;
  for (const NodeShare& node : nodes)
    most = std::max(most, tile_points_max(dimension, kernel, node.threads, node.memory_bytes));
  return most;
}

Status tile_fits_a_node(int dimension, KernelKind kernel, std::uint64_t points, std::span<const NodeShare> nodes) {
  if (points <= tile_points_max(dimension, kernel, nodes)) return success();
  const auto most = std::max_element(nodes.begin(), nodes.end(), [](const NodeShare& a, const NodeShare& b) {
    return a.memory_bytes < b.memory_bytes;
  });
  return error(Errc::memory, "a tile of " + std::to_string(points) + " points needs about " +
                                 in_mebibytes(tile_working_bytes(dimension, kernel, points)) +
                                 " of memory beside what a node needs itself, and no node has so much: of " +
                                 std::to_string(nodes.size()) + " node " + most->name + " gives a job most, " +
                                 in_mebibytes(most->memory_bytes) + "; ask for smaller tiles, or give nodes more " +
                                 option("memory"));
}

Status tile_fits(int dimension, KernelKind kernel, std::uint64_t points, std::uint64_t tiles, std::uint32_t threads,
                 std::uint64_t memory_bytes) {
  // One tile at a time may be worked on while all others sleep: the threads wait for it.
  const std::uint64_t bytes = tile_working_bytes(dimension, kernel, points);
  const auto enough = [&](std::uint64_t memory) {
    return bytes <= left_for_tiles(memory, threads, tiles) && fitting(dimension, kernel, 100, threads, memory) >= 100;
  };
  if (enough(memory_bytes)) return success();
  const std::string least = in_mebibytes(least_memory(enough));
  if (bytes < tiles * tile_bytes) {
    return error(Errc::memory, std::to_string(tiles) + " tiles need about " + in_mebibytes(tiles * tile_bytes) +
                                   " of memory beside their points, which " + option("memory") +
                                   " does not allow; ask for fewer tiles, or give at least " + least);
  }
  return error(Errc::memory, "a tile of " + std::to_string(points) + " points needs about " + in_mebibytes(bytes) +
                                 " of memory, which " + option("memory") +
                                 " does not allow; ask for smaller tiles, or give at least " + least);
}

}  // namespace tessera::budget

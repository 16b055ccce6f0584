#include "src/tiling/budget/budget.h"

#include <algorithm>

namespace tessera::budget {
namespace {

constexpr std::uint64_t mib = std::uint64_t{1} << 20;

// Returns what is left beside `taken`. Of a small budget that is little, but never nothing: too large tiles are refused
// elsewhere (tile_limit, tile_fits).
std::uint64_t beside(std::uint64_t memory_bytes, std::uint64_t taken) {
  return std::max(memory_bytes - std::min(memory_bytes, taken), memory_bytes / 8);
}

// What a reader holds: points that it has unpacked ahead (a LAZ chunk has 50,000 points), and batches on their way.
constexpr std::uint64_t reading_thread_bytes = 4 * mib;

// While points are routed there are no tiles, no messages and no result files.
std::uint64_t for_routing(std::uint64_t memory_bytes) { return beside(memory_bytes, fixed_bytes(0)); }

std::uint64_t whole_bytes(std::uint64_t points, std::uint64_t largest, const Needs& need, std::uint32_t threads) {
  return points * need.whole + threads * largest * (need.collect_whole + need.mesh);
}

}  // namespace

Needs needs(int dimension, KernelKind kernel, TileKind kind) {
  if (kind == TileKind::points) {
    Needs need = needs(dimension, kernel);
    need.whole = std::min(need.whole, need.image + 40);  // its own points stay beside what can still change
    need.collect = dimension == 3 && kernel == KernelKind::cgal ? 110 : 90;
    need.collect_whole = dimension == 3 && kernel == KernelKind::cgal ? 45 : 25;
    need.mesh = dimension == 3 ? 95 : 80;
    return need;
  }
  if (kernel == KernelKind::cgal) {
    if (dimension == 3) {
      return {.triangulate = 880, .whole = 620, .image = 200, .collect = 560, .collect_whole = 270, .mesh = 365};
    }
    return {.triangulate = 270, .whole = 215, .image = 60, .collect = 210, .collect_whole = 105, .mesh = 145};
  }
  if (dimension == 3) {
    return {.triangulate = 500, .whole = 280, .image = 120, .collect = 550, .collect_whole = 140, .mesh = 350};
  }
  return {.triangulate = 165, .whole = 120, .image = 40, .collect = 205, .collect_whole = 75, .mesh = 145};
}

// This is not the average. The scratch memory of a large conflict zone stays with the tile, so a few points may cost
// much.
std::uint64_t foreign_point_bytes(int dimension, KernelKind) { return dimension == 3 ? 1000 : 450; }

std::uint64_t region_bytes(int dimension, std::uint64_t points, std::uint64_t row_bytes) {
  return points * ((dimension == 3 ? 800 : 330) + row_bytes);
}

std::uint64_t sleep_percent(KernelKind kernel) { return kernel == KernelKind::cgal ? 45 : 120; }

std::uint64_t wake_percent(KernelKind kernel) { return kernel == KernelKind::cgal ? 105 : 200; }

std::uint64_t fixed_bytes(std::uint32_t threads) {
  // For each thread: a block for writing, a stack, and what the allocator keeps for it.
  return 25 * mib + threads * (3 * mib / 2);
}

std::uint64_t for_tiles(std::uint64_t memory_bytes, std::uint32_t threads, std::uint64_t tiles) {
  // An eighth is for tiles that are falling asleep or waking up, and for holes between small arrays.
  return beside(memory_bytes, fixed_bytes(threads) + tiles * tile_bytes) / 8 * 7;
}

std::uint64_t outbox_bytes(std::uint64_t memory_bytes) { return memory_bytes / 8; }

std::uint64_t mail_bytes_max(std::uint64_t memory_bytes, std::uint64_t tiles) {
  // A sixteenth of the memory, in pieces that are worth a write, but not larger than one write profits from.
  constexpr std::uint64_t least = 320, most = 640 << 10;
  return std::clamp(memory_bytes / 16 / std::max<std::uint64_t>(1, tiles), least, most);
}

bool fits_whole(std::span<const std::uint64_t> tile_points, int dimension, KernelKind kernel, TileKind kind,
                std::uint32_t threads, std::uint64_t memory_bytes) {
  std::uint64_t points = 0, largest = 0;
  for (const std::uint64_t n : tile_points) {
    points += n;
    largest = std::max(largest, n);
  }
  const auto tiles =
      static_cast<std::uint64_t>(std::count_if(tile_points.begin(), tile_points.end(), [](auto n) { return n > 0; }));
  return whole_bytes(points, largest, needs(dimension, kernel, kind), threads) <=
         for_tiles(memory_bytes, threads, tiles);
}

std::uint64_t route_buffer_bytes(std::uint64_t memory_bytes) {
  // More is no gain: writes are long enough, and fresh memory costs time at its first touch.
  return std::min(for_routing(memory_bytes) / 2, 128 * mib);
}

std::uint64_t sample_points(std::uint64_t memory_bytes, std::uint64_t points) {
  constexpr std::uint64_t usual = 100'000, most = 1'000'000;
  // The sample exists up to four times: while it is thinned, and in the partition's builder.
  const std::uint64_t affordable = for_routing(memory_bytes) / 2 / (4 * sizeof(Point));
  return std::clamp<std::uint64_t>(affordable, 4096, std::clamp(points / 1000, usual, most));
}

std::uint64_t refine_bytes(std::uint64_t memory_bytes) { return for_routing(memory_bytes) / 4; }

std::uint32_t reading_threads(std::uint64_t memory_bytes, std::uint32_t threads) {
  const std::uint64_t affordable = for_routing(memory_bytes) / 4 / reading_thread_bytes;
  return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(affordable, 1, std::max(1u, threads)));
}

Phases phases(int dimension, KernelKind kernel, TileKind kind, std::uint64_t points, std::uint64_t tile_points,
              std::uint32_t threads, std::uint64_t memory_bytes) {
  const Needs need = needs(dimension, kernel, kind);
  const std::uint64_t tile = std::min(points, tile_points);
  const std::uint64_t tiles = tile == 0 ? 0 : (points + tile - 1) / tile;
  const auto busy = static_cast<std::uint32_t>(std::min<std::uint64_t>(threads, tiles));
  const std::uint64_t base = fixed_bytes(threads) + tiles * tile_bytes;
  Phases all;
  all.whole = whole_bytes(points, tile, need, threads) <= for_tiles(memory_bytes, threads, tiles);
  const std::uint64_t kept = points * (all.whole ? need.whole : need.image);
  const std::uint64_t collect = all.whole ? need.collect_whole : need.collect;
  const auto add = [&](Phase phase, std::uint64_t bytes) {
    all.bytes.emplace_back(phase, std::min(bytes, memory_bytes));
  };
  const auto add_step = [&](StageStep step, std::uint64_t bytes) { add(phase_of(ProgramKind::delaunay, step), bytes); };
  add(Phase::routing, fixed_bytes(0) + reading_threads(memory_bytes, threads) * reading_thread_bytes +
                          std::min(route_buffer_bytes(memory_bytes), points * (sizeof(LocalPoint) + 8)));
  add_step(StageStep::begin, base + kept + busy * tile * (need.triangulate - (all.whole ? need.whole : need.image)));
  add_step(StageStep::exchange, base + kept);
  add_step(StageStep::store, base + kept + busy * tile * (collect + need.mesh));
  return all;
}

}  // namespace tessera::budget

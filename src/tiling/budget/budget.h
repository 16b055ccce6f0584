// The memory model: what tiles, mail, buffers and the process itself need, as pure functions. All code that reserves,
// refuses or predicts memory asks here. bench/budget compares the figures with measurements (docs/benchmarks.md).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/phases.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/base/tile_kind.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera::budget {

// Bytes per point of a tile, as measured on uniform points. Other clouds need less (bench/budget).
struct Needs {
  std::uint64_t triangulate = 0;  // while it is loaded, triangulated, reduced and announced; everything included
  std::uint64_t whole = 0;        // kept with all its cells, and with its points
  std::uint64_t image = 0;        // kept with what can still change, for a tile of which no more is known
  // while the mesh of a reduced tile is made: on top of what the tile holds; includes its points
  std::uint64_t collect = 0;
  std::uint64_t collect_whole = 0;  // the same for a tile that was kept whole
  std::uint64_t mesh = 0;           // while its mesh waits to be stored, and is stored
};
// With TileKind::points final cells are dropped as soon as they are known, so tiles need less.
Needs needs(int dimension, KernelKind kernel, TileKind kind = TileKind::cells);

// Returns the bytes that a point of mail may cost the tile that inserts it: a vertex, its cells, and what is known of
// the tiles that were told of it.
std::uint64_t foreign_point_bytes(int dimension, KernelKind kernel);

// In percent of the bytes that a tile holds: sleep_percent() is what the tile needs on top of them while it is written
// to disk. wake_percent() is what it needs in all while it is read back.
std::uint64_t sleep_percent(KernelKind kernel);
std::uint64_t wake_percent(KernelKind kernel);

// Returns the bytes of a region that is triangulated from `points` points: the points, their attributes, their
// triangulation by the flat kernel, which grows, and the list of its cells.
std::uint64_t region_bytes(int dimension, std::uint64_t points, std::uint64_t row_bytes);

// Resident memory of a process without tiles: program, libraries, log, and what each thread keeps ready.
std::uint64_t fixed_bytes(std::uint32_t threads);
// What a process keeps for each tile of a job, also while the tile sleeps: its actor, its counters, its entries in plan
// and schedule, what others know of it (measured: 2.9 KB in 2D, 3.4 KB in 3D, tests/actors/tile_memory_test.cc), and
// the few points of mail that are not worth a write.
inline constexpr std::uint64_t tile_bytes = 5 << 10;
// Returns what is left of a process's memory for the points of `tiles` tiles and their mail.
std::uint64_t for_tiles(std::uint64_t memory_bytes, std::uint32_t threads, std::uint64_t tiles);
// Returns how many bytes of mail one of `tiles` tiles keeps in memory before it puts them on disk.
std::uint64_t mail_bytes_max(std::uint64_t memory_bytes, std::uint64_t tiles);

// Whether all tiles fit whole into memory, while every thread collects one tile and another tile is on its way to the
// store. `tile_points`: by tile; entries may be 0.
bool fits_whole(std::span<const std::uint64_t> tile_points, int dimension, KernelKind kernel, TileKind kind,
                std::uint32_t threads, std::uint64_t memory_bytes);

// While points are routed: the bytes of the buffer that sorts points into tiles; the points of the sample that decides
// where a cloud of `points` points is cut, which grows with the cloud as the number of tiles does; the bytes for the
// sample by which a tile that became too large is cut; the threads that may read ahead.
std::uint64_t route_buffer_bytes(std::uint64_t memory_bytes);
std::uint64_t sample_points(std::uint64_t memory_bytes, std::uint64_t points);
std::uint64_t refine_bytes(std::uint64_t memory_bytes);
std::uint32_t reading_threads(std::uint64_t memory_bytes, std::uint32_t threads);

// Returns how many points a tile of a cloud of `points` should hold at most. That many fit while every thread works on
// a tile and the mail of other tiles waits, but tiles are small enough that all threads have several to work on. Error
// memory, with the least memory that would do, when even a small tile would not fit.
Result<std::uint64_t> tile_limit(int dimension, KernelKind kernel, std::uint64_t points, std::uint32_t threads,
                                 std::uint64_t memory_bytes);
// Error memory, with the least memory that would do, when one of `tiles` tiles, with `points` points, cannot be
// triangulated within the memory even if everything else waits on disk.
Status tile_fits(int dimension, KernelKind kernel, std::uint64_t points, std::uint64_t tiles, std::uint32_t threads,
                 std::uint64_t memory_bytes);

// Returns how much of a node's memory for its share of a job may hold what waits for other nodes or was sent to them.
std::uint64_t outbox_bytes(std::uint64_t memory_bytes);
// tile_working_bytes() returns what a tile of `points` points needs while it is worked on. tile_points_max() returns
// how many points a tile may have at most on a node with this memory.
std::uint64_t tile_working_bytes(int dimension, KernelKind kernel, std::uint64_t points);
std::uint64_t tile_points_max(int dimension, KernelKind kernel, std::uint32_t threads, std::uint64_t memory_bytes);
// What a node of a cluster gives to a job.
struct NodeShare {
  std::string name;
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
};
// tile_points_max() returns the most points that a tile may have on any of the nodes. tile_fits_a_node() returns error
// memory when a tile has more, with the need and the most that a node has. REQUIRES: there are nodes.
std::uint64_t tile_points_max(int dimension, KernelKind kernel, std::span<const NodeShare> nodes);
Status tile_fits_a_node(int dimension, KernelKind kernel, std::uint64_t points, std::span<const NodeShare> nodes);

// What each phase of a job takes: resident bytes, at most the memory. The job has `points` points in tiles of
// `tile_points`.
struct Phases {
  std::vector<std::pair<Phase, std::uint64_t>> bytes;  // in order; phases that are not listed take next to nothing
  bool whole = false;  // tiles keep all their cells, so no final cells are put on disk meanwhile
};
Phases phases(int dimension, KernelKind kernel, TileKind kind, std::uint64_t points, std::uint64_t tile_points,
              std::uint32_t threads, std::uint64_t memory_bytes);

}  // namespace tessera::budget

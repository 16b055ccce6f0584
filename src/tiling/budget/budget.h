// The memory model: what tiles, mail, buffers and the process itself need, as pure functions. Everybody who reserves,
// refuses or predicts memory asks here; bench/budget compares the figures with what is measured (docs/benchmarks.md).
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

// Bytes a point of a tile, as measured on uniform points; other clouds need less (bench/budget).
struct Needs {
  std::uint64_t triangulate = 0;    // while it is loaded, triangulated, reduced and announced, everything counted
  std::uint64_t whole = 0;          // kept with all its cells, its points beside them
  std::uint64_t image = 0;          // kept with what can still change, for a tile of which no more is known
  std::uint64_t collect = 0;        // while the mesh of a reduced tile is made, on top of what it holds; its points too
  std::uint64_t collect_whole = 0;  // the same for a tile that was kept whole
  std::uint64_t mesh = 0;           // while its mesh waits to be stored and is
};
// Where points are kept of tiles, final cells go as soon as they are known.
Needs needs(int dimension, KernelKind kernel, TileKind kind = TileKind::cells);

// Bytes a point of mail may cost the tile that inserts it: a vertex, its cells, what is known of who was told.
std::uint64_t foreign_point_bytes(int dimension, KernelKind kernel);

// In percent of the bytes that a tile holds: what it needs on top of them while it is written to disk, and in all while
// it is read back until it holds them again.
std::uint64_t sleep_percent(KernelKind kernel);
std::uint64_t wake_percent(KernelKind kernel);

// What a region takes that is triangulated from `points` points: they, what they carry, their triangulation by the flat
// kernel, which grows, and the list of its cells.
std::uint64_t region_bytes(int dimension, std::uint64_t points, std::uint64_t row_bytes);

// Resident memory of a process that has no tiles: program, libraries, log, what each thread keeps at hand.
std::uint64_t fixed_bytes(std::uint32_t threads);
// What a process keeps for each tile of a job, also while it sleeps: its actor, its counters, its place in plan and
// schedule, what others know of it (measured: 2.9 KB in 2D, 3.4 KB in 3D, tests/actors/tile_memory_test.cc), the plan,
// and the few points of mail that are not worth a write.
inline constexpr std::uint64_t tile_bytes = 5 << 10;
// What is left of a process's memory for the points of `tiles` tiles and their mail.
std::uint64_t for_tiles(std::uint64_t memory_bytes, std::uint32_t threads, std::uint64_t tiles);
// Bytes of mail that one of `tiles` tiles keeps in memory before it puts them on disk.
std::uint64_t mail_bytes_max(std::uint64_t memory_bytes, std::uint64_t tiles);

// Whether all tiles fit whole, every thread collecting one and another one on its way to the store.
// `tile_points`: by tile; may be 0.
bool fits_whole(std::span<const std::uint64_t> tile_points, int dimension, KernelKind kernel, TileKind kind,
                std::uint32_t threads, std::uint64_t memory_bytes);

// While points are routed: bytes of the buffer that sorts them into tiles, points of the sample that tells where to
// cut `points` points, of which there are many tiles when they are many, bytes for the sample by which a tile that
// became too large is cut, threads that may read ahead.
std::uint64_t route_buffer_bytes(std::uint64_t memory_bytes);
std::uint64_t sample_points(std::uint64_t memory_bytes, std::uint64_t points);
std::uint64_t refine_bytes(std::uint64_t memory_bytes);
std::uint32_t reading_threads(std::uint64_t memory_bytes, std::uint32_t threads);

// Points a tile should hold at most, of a cloud of `points`: what fits while every thread works on one and the mail of
// others waits, but small enough that all threads have several to work on. Error memory, with the least that would do,
// when even a small tile would not fit.
Result<std::uint64_t> tile_limit(int dimension, KernelKind kernel, std::uint64_t points, std::uint32_t threads,
                                 std::uint64_t memory_bytes);
// Error memory, with the least that would do, when one of `tiles` tiles of `points` each cannot be triangulated within
// the memory, whatever else waits on disk.
Status tile_fits(int dimension, KernelKind kernel, std::uint64_t points, std::uint64_t tiles, std::uint32_t threads,
                 std::uint64_t memory_bytes);

// Of a node's memory for its part of a job on many nodes: what waits for other nodes, and was sent to them.
std::uint64_t gate_bytes(std::uint64_t memory_bytes);
// What a tile of so many points needs while it is worked on; and how many it may have where a part of a job on many
// nodes has this.
std::uint64_t tile_working_bytes(int dimension, KernelKind kernel, std::uint64_t points);
std::uint64_t tile_points_max(int dimension, KernelKind kernel, std::uint32_t threads, std::uint64_t memory_bytes);
// What a node of a cluster gives a job.
struct NodeShare {
  std::string name;
  std::uint32_t threads = 1;
  std::uint64_t memory_bytes = 0;
};
// The most points that a tile may have on any of them. Error memory when a tile has more, with the need and the most
// that a node has. REQUIRES: there are nodes.
std::uint64_t tile_points_max(int dimension, KernelKind kernel, std::span<const NodeShare> nodes);
Status tile_fits_a_node(int dimension, KernelKind kernel, std::uint64_t points, std::span<const NodeShare> nodes);

// What a job of `points` points in tiles of `tile_points` takes in each phase: resident bytes, at most the memory.
struct Phases {
  std::vector<std::pair<Phase, std::uint64_t>> bytes;  // in order; the others take next to nothing
  bool whole = false;  // tiles are kept with all their cells: nothing final is put on disk meanwhile
};
Phases phases(int dimension, KernelKind kernel, TileKind kind, std::uint64_t points, std::uint64_t tile_points,
              std::uint32_t threads, std::uint64_t memory_bytes);

}  // namespace tessera::budget

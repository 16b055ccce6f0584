// The real actors under CAF's deterministic scheduler: every seed is another interleaving, and the same seed the same
// one. Each run is compared with CGAL's triangulation of the whole cloud.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "actors/harness/memory_faults.h"
#include "src/exchange/tile_program.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/tiling/partition.h"

namespace tessera {

// What may go wrong in a run.
struct HarnessFaults {
  bool storage = false;      // it fails once, or memory runs out
  bool kill = false;         // nodes are killed
  bool pause = false;        // nodes are given up though they live: some stop for a while before, and go on after
  bool join = false;         // nodes come later
  bool coordinator = false;  // the coordinator is killed, and another one takes over
  bool leave = false;        // nodes leave in order, the last one, too, when another comes
  bool last = false;         // all nodes are lost, one after the other; another comes, and some that cannot be used
  bool all = false;          // all nodes are lost at once, with the coordinator or without, and come again

  bool nodes() const { return kill || pause || join || leave || last || all; }
  // Nothing of what was done is lost.
  bool orderly() const { return leave && !(kill || pause || last || all || storage); }
  bool waits() const { return coordinator || leave || last || all; }  // for processes that come
};

// What the tiles run when the triangulation stands, and how it is known that it was right.
class LaterStages {
 public:
  virtual ~LaterStages() = default;
  virtual std::uint32_t count() const { return 1; }
  // Of the stage with this number, from 0. `tiles`: what the triangulation has left. Lives as long as the programs.
  virtual std::shared_ptr<const TilePrograms> programs(std::uint32_t stage,
                                                       const std::map<TileId, TileMesh>& tiles) = 0;
  // What is kept of tiles that have come to its end: as a disk would keep it.
  virtual std::vector<TileReceipt> stored(std::uint32_t stage) const = 0;
  // "", or what is wrong. All tiles have come to the end.
  virtual std::string wrong(const std::map<TileId, TileMesh>& tiles) const = 0;
};

struct HarnessOptions {
  std::string kind = "uniform";  // src/geometry/reference/clouds.h
  int dimension = 3;
  std::size_t points = 40;
  std::uint32_t tiles = 7;
  PartitionKind partition = PartitionKind::kdtree;
  std::uint32_t nodes = 0;                      // 0: drawn, 1 to 3
  std::optional<std::uint64_t> mail_bytes_max;  // that a tile keeps in memory; else drawn
  HarnessFaults faults;
  std::function<std::unique_ptr<LaterStages>()> later_stages;  // made for each seed; none: there are none
  MemoryFaults* memory_faults = nullptr;                       // memory runs out when it says so; null: never
  bool restarts = false;                          // the processes end, once or twice, and the run is resumed
  std::uint64_t first_seed = 1, last_seed = 1;    // inclusive
  std::function<void(const std::string&)> trace;  // hears of every step
  std::stop_token stop = {};                      // once requested, the run under way is left at its next step
};

struct HarnessReport {
  std::uint64_t seeds = 0;  // that passed
  std::uint64_t steps = 0;  // actor messages handled
  std::uint64_t updates = 0, waves = 0, sleeps = 0, spills = 0;
  std::uint64_t failures = 0;  // runs that a fault ended, with an error
  std::uint64_t restarts = 0, settled_restarts = 0;
  std::uint64_t later_restarts = 0;  // of them, while a later stage ran, or before it began
  std::uint64_t epochs = 0;          // that losses and joining have begun
  std::uint64_t nodes_lost = 0;      // in runs that ended well
  std::uint64_t mended = 0;          // runs that were begun again for damage found late
  // The first seed whose run was wrong, and how: cells that differ, quiescence believed too early, or no end.
  std::optional<std::uint64_t> failed_seed;
  std::string failure;
};

// The seed decides, each independently: cloud, schedule, delays, the number of grants under way, the memory budget
// (some force every tile to sleep after each step, some a part of them), whether tiles are reduced, whether they keep
// points alone, how much mail they keep in memory, whether they announce, nodes and who lives where, how late meshes
// are stored, faults and restarts. At every step the counters of all tiles differ by the updates that are under way.
HarnessReport run_harness(const HarnessOptions& options);

}  // namespace tessera

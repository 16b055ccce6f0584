// Runs the real actors under CAF's deterministic scheduler. Every seed is another interleaving, and the same seed is
// always the same one. The result of each run is compared with CGAL's triangulation of the whole cloud.
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
  bool storage = false;      // one call of the storage fails, or memory runs out
  bool kill = false;         // nodes are killed
  bool pause = false;        // nodes are given up though they live; some of them stop for a while, and go on
  bool join = false;         // nodes come later
  bool coordinator = false;  // the coordinator is killed, and another one takes over
  bool leave = false;        // nodes leave in order; when the last one leaves, another one comes
  // All nodes are lost, one after the other; another one comes, and perhaps one that cannot be used.
  bool last = false;
  bool all = false;  // all nodes are lost at once, with or without the coordinator, and others come

  bool nodes() const { return kill || pause || join || leave || last || all; }
  // Returns whether nodes leave in order, and no fault loses work.
  bool orderly() const { return leave && !(kill || pause || last || all || storage); }
  bool waits() const { return coordinator || leave || last || all; }  // jobs must wait for processes that come
};

// The stages after the triangulation, and the check of what they have computed.
class LaterStages {
 public:
  virtual ~LaterStages() = default;
  virtual std::uint32_t count() const { return 1; }
  // As in ScheduleOptions.
  virtual std::uint64_t unbuilt_bytes() const { return 0; }
  // Returns the programs of the stage with this number, from 0. `tiles` is the finished triangulation, and lives as
  // long as the programs.
  virtual std::shared_ptr<const TilePrograms> programs(std::uint32_t stage,
                                                       const std::map<TileId, TileMesh>& tiles) = 0;
  // Returns the receipts of the tiles that have come to the end of the stage, as a disk would keep them.
  virtual std::vector<TileReceipt> stored(std::uint32_t stage) const = 0;
  // Returns "" or what is wrong. Called when all tiles have come to the end.
  virtual std::string wrong(const std::map<TileId, TileMesh>& tiles) const = 0;
};

struct HarnessOptions {
  std::string kind = "uniform";  // src/geometry/reference/clouds.h
  int dimension = 3;
  std::size_t points = 40;
  std::uint32_t tiles = 7;
  PartitionKind partition = PartitionKind::kdtree;
  bool periodic = false;                        // each seed draws periods, along some axes or all; without later stages
  std::uint32_t nodes = 0;                      // 0: drawn, 1 to 3
  std::optional<std::uint64_t> mail_bytes_max;  // that a tile keeps in memory; no value: drawn
  HarnessFaults faults;
  std::function<std::unique_ptr<LaterStages>()> later_stages;  // makes them for each seed; empty: there are none
  MemoryFaults* memory_faults = nullptr;                       // decides when memory runs out; null: never
  bool restarts = false;                          // the processes end once or twice, and the run is resumed
  std::uint64_t first_seed = 1, last_seed = 1;    // inclusive
  std::function<void(const std::string&)> trace;  // hears of every step
  std::stop_token stop = {};                      // ends the run under way at its next step
};

struct HarnessReport {
  std::uint64_t seeds = 0;  // seeds that passed
  std::uint64_t steps = 0;  // actor messages handled
  std::uint64_t updates = 0, waves = 0, sleeps = 0, spills = 0;
  std::uint64_t failures = 0;  // runs that a fault has ended with an error
  std::uint64_t restarts = 0, settled_restarts = 0;
  std::uint64_t later_restarts = 0;  // restarts while a later stage ran, or before it began
  std::uint64_t epochs = 0;          // made by losses and by nodes that joined
  std::uint64_t nodes_lost = 0;      // in runs that ended well
  std::uint64_t mended = 0;          // runs that began again because damage was found late
  // The first seed whose run was wrong, and how: wrong cells, quiescence believed too early, no end, ...
  std::optional<std::uint64_t> failed_seed;
  std::string failure;
};

// Runs all seeds of the options, up to the first failure. The seed draws, each independently: the cloud, the schedule,
// delays, the number of permits, the memory budget (some budgets make every tile sleep after each step, some a part of
// the tiles), whether tiles are reduced, whether only points are kept of them, how much mail they keep in memory,
// whether they announce, the nodes and their tiles, how late tiles are stored, faults and restarts. After every step
// the counters of all tiles must differ by the number of updates under way.
HarnessReport run_harness(const HarnessOptions& options);

}  // namespace tessera

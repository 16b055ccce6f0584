// What one seed of the harness runs: a cloud cut into tiles, and the circumstances.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "actors/harness/harness.h"
#include "actors/harness/memory_storage.h"
#include "src/run/delaunay_program.h"
#include "src/run/part.h"
#include "src/tiling/partition.h"

namespace tessera {

struct Setting {
  std::vector<LocalPoint> cloud;
  std::vector<std::vector<LocalPoint>> tiles;
  std::shared_ptr<const std::vector<std::uint64_t>> tile_points;  // how many these are
  PartSpec spec;
  std::uint32_t nodes = 1;
  DelaunayStage stage;  // without storage and stop
  TileContext context;  // without programs, storage and watch; the table of the spec
  ScheduleOptions schedule;
  std::uint32_t patience = 0;  // of the network
  GateOptions gates;
  bool late_stores = false;
};

// A cloud as production cuts it, and the seeds it finds. By tile.
struct CutCloud {
  std::vector<std::vector<LocalPoint>> tiles;
  std::vector<Bounds> bounds;
  std::vector<Seed> seeds;
};
CutCloud cut(const std::vector<LocalPoint>& cloud, const Partition& partition);

std::shared_ptr<const std::vector<std::uint64_t>> points_of(const std::vector<std::vector<LocalPoint>>& tiles);

Setting make_setting(const HarnessOptions& options, std::uint64_t seed, std::mt19937_64& rng);

// Parts whose points and scratch are in memory.
class MemoryParts final : public PartSource {
 public:
  // `home`: whose scratch it is, whatever number the node has in the job. `watch`: may be null. All outlive this.
  MemoryParts(const Setting& setting, MemoryStorage& storage, ExchangeWatch* watch, NodeId home)
      : setting_(setting), storage_(storage), watch_(watch), home_(home) {}
  Result<std::unique_ptr<Part>> open(const PartSpec& spec, NodeId self) override;

 private:
  const Setting& setting_;
  MemoryStorage& storage_;
  ExchangeWatch* watch_;
  NodeId home_;
};

}  // namespace tessera

// What one seed of the harness runs: a cloud cut into tiles, and the circumstances.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "actors/harness/harness.h"
#include "actors/harness/memory_storage.h"
#include "src/delaunay/delaunay_program.h"
#include "src/exchange/share.h"
#include "src/tiling/partition.h"

namespace tessera {

struct Setting {
  std::vector<LocalPoint> cloud;
  std::vector<std::vector<LocalPoint>> tiles;
  std::shared_ptr<const std::vector<std::uint64_t>> tile_points;  // how many these are
  ShareSpec spec;
  std::shared_ptr<const RoutingTable> table;  // of the spec
  std::uint32_t nodes = 1;
  DelaunayStage stage;  // without storage, store and stop
  TileContext context;  // without programs, storage and watch
  ScheduleOptions schedule;
  std::uint32_t patience = 0;  // of the network
  OutboxOptions outboxes;
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
class MemoryShares final : public ShareSource {
 public:
  // `home`: whose scratch it is, whatever number the node has in the job. `watches`: by stage; they may be null.
  // `later`: null, there is none. All outlive this.
  MemoryShares(const Setting& setting, MemoryStorage& storage, std::vector<ExchangeWatch*> watches, NodeId home,
               LaterStages* later = nullptr)
      : setting_(setting), storage_(storage), watches_(std::move(watches)), home_(home), later_(later) {}
  Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) override;

 private:
  std::shared_ptr<const TilePrograms> programs(Share& part, std::uint32_t stage) const;
  std::vector<TileReceipt> stored(std::uint32_t stage) const;

  const Setting& setting_;
  MemoryStorage& storage_;
  std::vector<ExchangeWatch*> watches_;
  NodeId home_;
  LaterStages* later_;
};

}  // namespace tessera

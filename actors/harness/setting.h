// What one seed of the harness runs: a cloud that is cut into tiles, and the circumstances.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "actors/harness/harness.h"
#include "actors/harness/memory_storage.h"
#include "src/base/image.h"
#include "src/delaunay/delaunay_program.h"
#include "src/exchange/share.h"
#include "src/tiling/partition.h"

namespace tessera {

struct Setting {
  std::vector<LocalPoint> cloud;
  Period period;  // of the cloud
  std::vector<std::vector<LocalPoint>> tiles;
  std::shared_ptr<const std::vector<std::uint64_t>> tile_points;  // number of points of each tile
  ShareSpec spec;
  std::shared_ptr<const RoutingTable> table;  // the table of `spec`
  std::uint32_t nodes = 1;
  DelaunayStage stage;  // without storage, store and stop
  TileContext context;  // without programs, storage and watch
  ScheduleOptions schedule;
  std::uint32_t patience = 0;  // of the network
  OutboxOptions outboxes;
  bool late_stores = false;
};

// A cloud cut into tiles as production does it, and the seeds that production finds. Both arrays are by tile.
struct CutCloud {
  std::vector<std::vector<LocalPoint>> tiles;
  std::vector<Bounds> bounds;
  std::vector<Seed> seeds;
};
CutCloud cut(const std::vector<LocalPoint>& cloud, const Partition& partition, const Period& period = {});

// Returns the number of points of each tile.
std::shared_ptr<const std::vector<std::uint64_t>> points_of(const std::vector<std::vector<LocalPoint>>& tiles);

Setting make_setting(const HarnessOptions& options, std::uint64_t seed, std::mt19937_64& rng);

// Opens shares whose points and scratch are in memory.
class MemoryShares final : public ShareSource {
 public:
  // `home` is the node whose scratch is used, whatever number the node has in the job. `watches` is by stage; entries
  // may be null. `later` is null when there are no later stages. All arguments outlive this object.
  MemoryShares(const Setting& setting, MemoryStorage& storage, std::vector<ExchangeWatch*> watches, NodeId home,
               LaterStages* later = nullptr)
      : setting_(setting), storage_(storage), watches_(std::move(watches)), home_(home), later_(later) {}
  Result<std::unique_ptr<Share>> open(const ShareSpec& spec, NodeId self) override;

 private:
  std::shared_ptr<const TilePrograms> programs(Share& share, std::uint32_t stage) const;
  std::vector<TileReceipt> stored(std::uint32_t stage) const;

  const Setting& setting_;
  MemoryStorage& storage_;
  std::vector<ExchangeWatch*> watches_;
  NodeId home_;
  LaterStages* later_;
};

}  // namespace tessera

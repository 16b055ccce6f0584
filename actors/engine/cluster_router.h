// Routes an input on the nodes of a cluster, and in this process what the nodes cannot read.
#pragma once

#include <functional>
#include <string>

#include "actors/engine/membership.h"
#include "src/tiling/split_router.h"

namespace tessera {

class ClusterRouter final : public SplitRouter {
 public:
  // `system` and `seat` outlive this object. `memory_bytes` is for what is routed in this process.
  ClusterRouter(caf::actor_system& system, const Membership& seat, std::uint64_t memory_bytes)
      : system_(system), seat_(seat), memory_bytes_(memory_bytes) {}
  std::uint64_t split_points(std::uint64_t total) const override;
  Result<std::vector<std::uint32_t>> route(const Cloud& cloud, const std::vector<InputSplit>& splits,
                                           const Partition& partition, const std::filesystem::path& run_folder,
                                           Progress& progress, const std::stop_token& stop) override;

 private:
  caf::actor_system& system_;
  const Membership& seat_;
  std::uint64_t memory_bytes_;
};

}  // namespace tessera

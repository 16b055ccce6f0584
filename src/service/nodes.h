// The nodes that work on the jobs: those of a cluster, or this process alone.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "actors/engine/engine.h"
#include "src/service/jobs/job_table.h"
#include "src/service/nodes_backend.h"

namespace tessera::service {

class Nodes final : public NodesBackend {
 public:
  // `cluster` says whether the engine works with other nodes. `memory_bytes` is this process's.
  Nodes(Engine& engine, const JobTable& jobs, bool cluster, std::uint64_t memory_bytes)
      : engine_(engine), jobs_(jobs), cluster_(cluster), memory_bytes_(memory_bytes) {}

  Reply<proto::NodeList> list() override;
  Reply<proto::NodeInfo> drain(std::string_view node, const Caller& caller) override;

 private:
  NodeState own_node() const;
  // Tiles of running jobs that are not stored yet.
  std::map<std::string, std::uint64_t> tiles_by_node() const;

  Engine& engine_;
  const JobTable& jobs_;
  const bool cluster_;
  const std::uint64_t memory_bytes_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace tessera::service

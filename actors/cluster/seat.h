// A process's seat in a cluster: what it listens with, its place as a node, and the cluster's coordinator if it is
// that. Used from any thread; nothing of it may be called from an actor, for it waits.
#pragma once

#include <caf/all.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "actors/cluster/messages.h"
#include "src/base/result.h"
#include "src/cluster/cluster_options.h"

namespace tessera {

class Seat {
 public:
  struct Own {  // of this process
    caf::actor node;
    std::uint32_t threads = 1;
    std::uint64_t memory_bytes = 0;
    std::function<std::uint64_t()> memory_used;
  };
  // Error io when it cannot listen there. The system has loaded the network (network.h).
  static Result<std::unique_ptr<Seat>> take(caf::actor_system& system, ClusterOptions options, const Own& own);
  ~Seat();
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

  const HostPort& address() const { return options_.advertised; }
  const NodeUuid& uuid() const { return uuid_; }  // of this process as a node; empty: it is none
  // REQUIRES of the rest: it is the coordinator.
  MemberList members() const;
  // Nodes free for work; waits until there is one. None: `stop` was requested. `gathering`: a job goes on that others
  // may still be working on, so give all of them the time to come back.
  std::vector<NodeHandle> nodes(bool gathering, const std::stop_token& stop) const;
  // A job's coordinator hears of nodes from now on.
  void follow(const CoordinatorHandle& job) const;
  Drained drain(const std::string& node) const;

 private:
  Seat(caf::actor_system& system, ClusterOptions options) : system_(system), options_(std::move(options)) {}

  caf::actor_system& system_;
  ClusterOptions options_;
  RegistryHandle registry_;
  MemberHandle member_;
  NodeUuid uuid_;
  std::uint16_t port_ = 0;
  std::chrono::steady_clock::time_point taken_ = std::chrono::steady_clock::now();
};

}  // namespace tessera

// What makes an engine one of a cluster: kept apart, so that what runs alone needs no network.
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "actors/protocol.h"
#include "src/base/result.h"
#include "src/cluster/cluster_options.h"
#include "src/cluster/members.h"

namespace tessera {

// Used from any thread; nothing of it may be called from an actor, for it waits.
class Membership {
 public:
  struct Own {  // of this process
    caf::actor node;
    std::uint32_t threads = 1;
    std::uint64_t memory_bytes = 0;
    std::function<std::uint64_t()> memory_used, jobs;  // of what it has; that it is at work for
  };
  virtual ~Membership() = default;
  virtual const ClusterOptions& options() const = 0;
  // Before there is a system.
  virtual void prepare(caf::actor_system_config& config) = 0;
  // Once; `system` lives until after leave(). Error io when it cannot listen there.
  virtual Status take(caf::actor_system& system, const Own& own) = 0;
  virtual void leave() noexcept = 0;

  // REQUIRES: this process is a node.
  virtual NodePlace place() const = 0;
  // As Engine::depart().
  virtual void depart() const = 0;

  // REQUIRES of the rest: it is the coordinator.
  virtual std::vector<NodeState> members() const = 0;  // in order of coming
  virtual std::uint64_t lost() const = 0;              // ever
  // Whether nodes of the coordinator before this one may still be on their way to it.
  virtual bool gathering() const = 0;
  // Nodes free for work; waits until there is one. None: `stop` was requested. `all`: a job goes on that others may
  // still be working on, so give all of them the time to come back; also those that are to leave.
  virtual std::vector<NodeHandle> nodes(bool all, const std::stop_token& stop) const = 0;
  // It hears of nodes from now on, and first of those there are.
  virtual void follow(const FollowerHandle& job) const = 0;
  // As Engine::drain().
  virtual Result<bool> drain(const std::string& node) const = 0;
};

}  // namespace tessera

// What an engine needs to belong to a cluster. An interface, so that a process without a cluster links no network code.
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

// Thread-safe. Functions wait for answers, so no actor may call them.
class Membership {
 public:
  struct Own {  // what this process is as a node
    caf::actor node;
    std::uint32_t threads = 1;
    std::uint64_t memory_bytes = 0;
    std::function<std::uint64_t()> memory_used, jobs;  // memory in use; number of jobs that it works for
  };
  virtual ~Membership() = default;
  virtual const ClusterOptions& options() const = 0;
  // Called before there is a system.
  virtual void prepare(caf::actor_system_config& config) = 0;
  // Joins the cluster. Called once; `system` lives until after leave(). Error io when the process cannot listen.
  virtual Status take(caf::actor_system& system, const Own& own) = 0;
  virtual void leave() noexcept = 0;

  // REQUIRES: this process is a node.
  virtual MembershipStatus membership_status() const = 0;
  // As Engine::depart().
  virtual void depart() const = 0;

  // REQUIRES, for all below: this process is the coordinator.
  virtual std::vector<NodeState> members() const = 0;  // in the order of coming
  virtual std::uint64_t lost() const = 0;              // nodes that were ever lost
  // Returns whether nodes of the coordinator before this one may still be on their way to it.
  virtual bool gathering() const = 0;
  // Returns the nodes that are free for work, and waits until there is one. Empty: `stop` was requested. `all` is for a
  // job that is continued and on which other nodes may still be working: it gives all of them the time to come back,
  // and returns those that are to leave, too.
  virtual std::vector<NodeHandle> nodes(bool all, const std::stop_token& stop) const = 0;
  // Tells `job` of nodes from now on, and first of those that are there.
  virtual void follow(const FollowerHandle& job) const = 0;
  // As Engine::drain().
  virtual Result<bool> drain(const std::string& node) const = 0;
};

}  // namespace tessera

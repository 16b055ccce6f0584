// The node of this process and the jobs that it runs; on the coordinator of a cluster, the jobs of the cluster. Jobs
// that run at once take turns on the engine's threads, and each uses at most as many as it asks for. Each job has
// memory of its own while it runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "actors/node_meter.h"
#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/cluster/members.h"
#include "src/delaunay/run/result_stages.h"
#include "src/delaunay/run/run_options.h"
#include "src/delaunay/run/run_summary.h"
#include "src/tiling/budget/budget.h"
#include "src/tiling/routed_cloud.h"

namespace tessera {

class Membership;  // membership.h

// Thread-safe.
class Engine {
 public:
  // `threads` work on tiles. Threads and memory are for all jobs together. `kinds` are the kinds of jobs over results
  // that the engine can run.
  Engine(std::uint32_t threads, std::uint64_t memory_bytes, KindsOfStages kinds = {});
  // The same, as a process of a cluster. Error io when it cannot listen.
  static Result<std::unique_ptr<Engine>> join(std::uint32_t threads, std::uint64_t memory_bytes,
                                              std::unique_ptr<Membership> membership, KindsOfStages kinds = {});
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // Runs the tiles of a routed cloud as actors until all is quiet, and stores them in `out`. Returns when nothing in
  // this process works on them any more, and their memory is free for another run.
  // Errors: interrupted when `stop` was requested (scratch stays, and the run can be resumed); memory, at once, when
  // other jobs have left too little; those of tiles and files.
  // Several threads may call this at once, for different runs. In a cluster only its coordinator may call it. All nodes
  // then work on the run, each with a share of its own threads and memory in place of those in `options`. Folders must
  // be seen by all nodes under the same path. Waits until there is a node.
  Result<RunSummary> run(const RoutedCloud& run, const std::filesystem::path& out, const RunOptions& options,
                         Progress& progress, std::stop_token stop);

  // Runs a job over the tiles of a result: all its stages, one after the other. `fraction` is told how much is done,
  // from 0 to 1. The outcome is in the job's run folder. Otherwise as the other run().
  Status run(const ResultJob& job, const std::function<void(double)>& fraction, Progress& progress,
             std::stop_token stop);

  // Returns what routes large inputs on other nodes; null when there is no cluster. The engine outlives it.
  std::unique_ptr<SplitRouter> router(std::uint64_t memory_bytes) const;

  // Threads that work on jobs, of all nodes that are there now.
  std::uint32_t threads() const;

  // What each node of a cluster that is free for work gives a job. Empty when that is not known yet, or there is no
  // cluster.
  std::vector<budget::NodeShare> shares() const;

  // What this process does as a node.
  NodeWork work() const;
  // Memory that is reserved for this node's shares: as much as they may use.
  std::uint64_t memory_used() const;
  // REQUIRES: this process is a node of a cluster.
  MembershipStatus membership_status() const;
  // Leaves the cluster in order, whatever process coordinates it by then: the node takes no more work, and other nodes
  // go on with its tiles. ClusterOptions::expelled is called when they can do so, or when there is no coordinator and
  // nothing that others could go on with.
  void depart() const;

  // Returns whether nodes that worked for the coordinator before this one may still be on their way. What that
  // coordinator began is to be continued when they have had the time to come. False without a cluster.
  bool gathering() const;
  // REQUIRES, for all below: this process is the coordinator of a cluster.
  std::vector<NodeState> nodes() const;  // in the order of coming
  std::uint64_t nodes_lost() const;      // since the coordinator began; drained nodes do not count
  // Takes all work from a node, given by name or uuid, and has its process end; the coordinator's own process goes on,
  // and is no node any more. Returns whether there is such a node. Error usage when it is the only one that is free for
  // work.
  Result<bool> drain(const std::string& node) const;

 private:
  struct Impl;
  explicit Engine(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera

// One process's node and the jobs it runs; in a cluster, the jobs of the cluster. Jobs that run at once take turns on
// the engine's threads, each on at most as many as it asks for; memory is each one's own while it runs.
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

class Engine {
 public:
  // For all jobs together: threads that work on tiles, and memory.
  // `kinds`: of jobs over results that it runs.
  Engine(std::uint32_t threads, std::uint64_t memory_bytes, KindsOfStages kinds = {});
  // The same as a process of a cluster. Error io when it cannot listen.
  static Result<std::unique_ptr<Engine>> join(std::uint32_t threads, std::uint64_t memory_bytes,
                                              std::unique_ptr<Membership> membership, KindsOfStages kinds = {});
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // Runs the tiles of a routed cloud as actors until message counting proves quiet, and stores them. Returns when
  // nothing works on them any more here, and its memory is free for another run. Error interrupted when `stop` was
  // requested: what is on scratch stays for a run that goes on; memory, at once, when the others have left too little.
  // Several threads may call this at once, for different runs. In a cluster, of its coordinator only: all nodes work on
  // it, each with a share of what it has in place of the threads and memory of the options, and folders are those that
  // all see; waits until there is a node.
  Result<RunSummary> run(const RoutedCloud& run, const std::filesystem::path& out, const RunOptions& options,
                         Progress& progress, std::stop_token stop);

  // The same for a job over the tiles of a result: its stages run to their end. `part`: told how much of it is done,
  // from 0 to 1. What it leaves stands in the job's run folder.
  Status run(const ResultJob& job, const std::function<void(double part)>& part, Progress& progress,
             std::stop_token stop);

  // Who routes a large input beside this process; null: nobody. The engine outlives it.
  std::unique_ptr<SplitRouter> router(std::uint64_t memory_bytes) const;

  // That work on jobs, of all nodes there are now.
  std::uint32_t threads() const;

  // What each node of a cluster that is free for work gives a job; none: it is not known yet, or there is no cluster.
  std::vector<budget::NodeShare> shares() const;

  // What this process does as a node.
  NodeWork work() const;
  std::uint64_t memory_used() const;  // of what it has, by the parts that it hosts: at most what they may use
  // REQUIRES: a node of a cluster.
  NodePlace place() const;
  // Leaves it in order, whoever coordinates it meanwhile: takes no more work, and others go on with its tiles. When
  // they can, or there is nobody to ask and nothing to go on with, `expelled` of its options is called.
  void depart() const;

  // Whether nodes that worked for the coordinator before this one may still be on their way: what it began goes on
  // when they have had the time. False without a cluster.
  bool gathering() const;
  // REQUIRES of the rest: the coordinator of a cluster.
  std::vector<NodeState> nodes() const;  // in order of coming
  std::uint64_t nodes_lost() const;      // since the coordinator began; not those drained
  // Takes all work from a node, by its name or uuid, and has its process end; the coordinator's own goes on without
  // being a node. Error usage when it is the only one free for work. Whether there is such a node.
  Result<bool> drain(const std::string& node) const;

 private:
  struct Impl;
  explicit Engine(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera

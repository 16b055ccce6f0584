// A cluster of processes on one machine, for trials and tests. Its state is in a file in its folder
// (src/base/files/names.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/local_process.h"

namespace tessera::apps {

struct LocalNode {
  std::string name;
  std::uint16_t port = 0;  // for the other nodes, on 127.0.0.1
  ProcessId process;       // the last process that was started
};

struct LocalCluster {
  std::filesystem::path folder;
  std::string boot;                // the boot of the machine in which its processes were started
  std::uint16_t api = 0;           // the port of its HTTP API
  std::uint64_t memory_bytes = 0;  // of each node
  std::uint32_t threads = 1;
  std::vector<std::string> inputs;  // folders that jobs may read
  std::vector<LocalNode> nodes;     // the first node is also the coordinator

  std::string url() const { return "http://127.0.0.1:" + std::to_string(api); }
  std::filesystem::path log_of(const LocalNode& node) const;
};

// Makes a cluster of `nodes` nodes, with certificates and free ports. Starts no processes. Error io.
Result<LocalCluster> new_local_cluster(const std::filesystem::path& folder, std::uint32_t nodes);
// Reads the cluster in a folder; returns no value if there is none. Errors: corrupt if its file is damaged; io.
Result<std::optional<LocalCluster>> read_local_cluster(const std::filesystem::path& folder);
Status write_local_cluster(const LocalCluster& cluster);

// Returns the process of a node; no value if it does not run. Error io.
Result<std::optional<RunningProcess>> process_of(const LocalCluster& cluster, const LocalNode& node);
// Starts the process of a node, and writes its id to the cluster's file. For the first node the function returns when
// the daemon answers, with its token in its file. Errors: io; also if the process ends at once, with its last line.
Status start_node(LocalCluster& cluster, LocalNode& node);
// Returns the last line of a node's log; "" if there is none.
std::string last_words(const LocalCluster& cluster, const LocalNode& node);

}  // namespace tessera::apps

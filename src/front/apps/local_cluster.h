// A cluster on one machine, to try and to test: what is remembered of it in its folder (src/base/files/names.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/front/apps/local_process.h"

namespace tessera {

struct LocalNode {
  std::string name;
  std::uint16_t port = 0;  // where other nodes reach it, on 127.0.0.1
  ProcessId process;       // the last that was started
};

struct LocalCluster {
  std::filesystem::path folder;
  std::string boot;                // under which its processes were started
  std::uint16_t api = 0;           // the port of its API
  std::uint64_t memory_bytes = 0;  // of each node
  std::uint32_t threads = 1;
  std::vector<std::string> inputs;  // folders
  std::vector<LocalNode> nodes;     // the first is the coordinator, too

  std::string url() const { return "http://127.0.0.1:" + std::to_string(api); }
  std::filesystem::path log_of(const LocalNode& node) const;
};

// Nodes, certificates and ports that nobody has now; no processes. Error io.
Result<LocalCluster> new_local_cluster(const std::filesystem::path& folder, std::uint32_t nodes);
// Nothing when there is none in the folder. Errors: corrupt when its file is damaged; io.
Result<std::optional<LocalCluster>> read_local_cluster(const std::filesystem::path& folder);
Status write_local_cluster(const LocalCluster& cluster);

// Nothing when it does not run. Error io.
Result<std::optional<RunningProcess>> process_of(const LocalCluster& cluster, const LocalNode& node);
// Starts a node's process and remembers it. The first one's has answered when this returns, and its token is in its
// file. Errors: io, also when it ends at once, with what it has said last.
Status start_node(LocalCluster& cluster, LocalNode& node);
// The last line of its log; empty when there is none.
std::string last_words(const LocalCluster& cluster, const LocalNode& node);

}  // namespace tessera

// Says how a process takes part in a cluster.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

struct HostPort {
  std::string host;
  std::uint16_t port = 0;
  friend bool operator==(const HostPort&, const HostPort&) = default;
};
// Parses "HOST:PORT" or "[IPV6]:PORT". Error usage.
Result<HostPort> parse_host_port(const std::string& text);
std::string to_string(const HostPort& address);
// Returns all numeric addresses that a name has now, with the same port. May wait for a name server. Error io when the
// name has no address.
Result<std::vector<HostPort>> addresses_of(const HostPort& named);

// The options of one process of a cluster.
struct ClusterOptions {
  std::string name = "tessera";  // of the cluster; processes of another cluster are refused
  std::string node_name;         // for display
  HostPort listen;               // where this process listens; needs a port
  HostPort advertised;           // where others reach this process; empty host, port 0: as `listen`
  // Where to look for the cluster; may contain this process. A name stands for all its addresses, and is looked up
  // again each time.
  std::vector<HostPort> join;
  // PEM files. Processes without a certificate of the same authority are refused.
  std::filesystem::path authority, certificate, key;
  std::uint64_t certificate_end_s = 0;   // end of validity, in seconds since 1970; 0: not known
  bool coordinator = true, node = true;  // the roles of this process
  std::chrono::milliseconds lease{10'000};
  std::uint32_t jobs_at_once = 1;  // jobs that run at once; each has an equal share of every node
  std::uint32_t grace_s = 300;     // seconds for which tiles go on without a coordinator
  // How long a node that is told to end may take to hand over its tiles; 0: as long as it takes.
  std::chrono::seconds drain_timeout{20};
  std::filesystem::path scratch;  // folder of this process, for tiles that are not in memory
  std::string shared;             // identifies the folder that all nodes share
  // That folder, as this process sees it: folders that others name must lie in it; empty: they may lie anywhere.
  std::filesystem::path data;
  std::function<void(const std::string&)> log = [](const std::string&) {};
  // Called once, from any thread, when the process is no longer a member. `again` true: the others count it as lost, or
  // refuse it, and it must begin anew. `again` false: it has left in order, and must end.
  std::function<void(const std::string& why, bool again)> expelled = [](const std::string&, bool) {};
};

}  // namespace tessera

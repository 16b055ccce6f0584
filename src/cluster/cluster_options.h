// How a process takes part in a cluster.
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
// "HOST:PORT" or "[V6]:PORT". Error usage.
Result<HostPort> parse_host_port(const std::string& text);
std::string to_string(const HostPort& address);
// All numeric addresses that a name has now. May wait for a name server. Error io: it has none.
Result<std::vector<HostPort>> addresses_of(const HostPort& named);

struct ClusterOptions {
  std::string name = "tessera";  // of the cluster: others are refused
  std::string node_name;         // for people
  HostPort listen;               // port 0: any
  HostPort advertised;           // by which others reach it; no host: as `listen`
  // Any node of the cluster; this process, too. A name stands for all its addresses, and is looked up again each time.
  std::vector<HostPort> join;
  // PEM. Whoever has no certificate of the same authority is not listened to.
  std::filesystem::path authority, certificate, key;
  std::uint64_t certificate_end_s = 0;   // until when that is valid, by the system's clock; 0: not known
  bool coordinator = true, node = true;  // what it is
  std::chrono::milliseconds lease{10'000};
  std::uint32_t jobs_at_once = 1;  // each has an equal share of every node
  std::uint32_t grace_s = 300;     // that tiles go on for without a coordinator
  // That a node which is told to end has for handing over what it has; none: as long as it takes.
  std::chrono::seconds drain_timeout{20};
  std::filesystem::path scratch;  // a folder of this process; of tiles that are not in memory
  std::string shared;             // tells the shared folder from any other one
  std::filesystem::path data;     // it, as this process sees it: what others name lies there; none: anywhere
  std::function<void(const std::string&)> log = [](const std::string&) {};
  // Called once, from any thread: the others count this process as lost, or cannot have it. It must begin anew
  // (`again`), or end: it has left in order.
  std::function<void(const std::string& why, bool again)> expelled = [](const std::string&, bool) {};
};

}  // namespace tessera

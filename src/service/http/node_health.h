// The health of a process that only works for a cluster, for supervisors and Prometheus. It has no API.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera::service::http {

struct NodeFigures {
  std::uint64_t memory_budget_bytes = 0;  // for all jobs together
  std::uint64_t memory_used_bytes = 0;    // of this, what the shares of running jobs may use now
  std::uint64_t tile_memory_bytes = 0;    // what their tiles hold now, inboxes included
  std::uint64_t scratch_free_bytes = 0;
  std::uint64_t jobs = 0;                           // of which it has a share now
  std::uint64_t tiles_asleep = 0;                   // on scratch, now
  std::uint64_t tiles_begun = 0, tiles_stored = 0;  // since the start
  std::uint64_t points = 0;                         // triangulated since the start
  std::uint64_t bytes_sent = 0, credit_waits = 0;   // to other nodes, and waits for credit, since the start
  std::uint64_t waiting_bytes = 0;                  // until other nodes have room, now
  std::uint64_t members = 0;                        // other processes of the cluster that it is connected to
  bool member = false;                              // its lease is valid
  double lease_seconds = 0, silent_seconds = 0;     // length of the lease; time since the coordinator was heard
  double certificate_end_s = 0;                     // when its certificate expires, since 1970
};

// Thread-safe.
class NodeHealth {
 public:
  virtual ~NodeHealth() = default;
  virtual NodeFigures figures() const = 0;
  // Nothing while the process works for the cluster; else the reason.
  virtual std::optional<std::string> unready() const = 0;
};

}  // namespace tessera::service::http

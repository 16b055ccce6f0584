// A process that only works for a cluster, as supervisors and Prometheus see it: it has no API.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tessera::http {

struct NodeFigures {
  std::uint64_t memory_budget_bytes = 0;  // for all jobs together
  std::uint64_t memory_used_bytes = 0;    // of it, what the parts of running jobs may use now
  std::uint64_t tile_memory_bytes = 0;    // what their tiles hold now, mail included
  std::uint64_t scratch_free_bytes = 0;
  std::uint64_t jobs = 0;                           // that it has a part of, now
  std::uint64_t tiles_asleep = 0;                   // on scratch, now
  std::uint64_t tiles_begun = 0, tiles_stored = 0;  // since the start
  std::uint64_t points = 0;                         // triangulated since the start
  std::uint64_t bytes_sent = 0, credit_waits = 0;   // to other nodes, and waited for, since the start
  std::uint64_t waiting_bytes = 0;                  // for other nodes to have room, now
  std::uint64_t members = 0;                        // other processes of the cluster that it reaches
  bool member = false;                              // its lease runs
  double lease_seconds = 0, silent_seconds = 0;     // how long it is, and since the coordinator was heard
  double certificate_end_s = 0;                     // when its certificate expires, since 1970
};

// Safe from any thread.
class NodeHealth {
 public:
  virtual ~NodeHealth() = default;
  virtual NodeFigures figures() const = 0;
  // Nothing while it works for the cluster, else why not.
  virtual std::optional<std::string> unready() const = 0;
};

}  // namespace tessera::http

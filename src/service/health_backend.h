// What front ends ask of the service's health: figures, and whether the service can work.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tessera::service {

struct ServiceFigures {
  std::uint64_t accepted = 0, running = 0;                  // now
  std::uint64_t successful = 0, failed = 0, dismissed = 0;  // since the start
  std::uint64_t points = 0;                                 // triangulated since the start
  std::uint64_t updates_waiting = 0;                        // in the inboxes of tiles or on the way there, now
  std::uint64_t memory_budget_bytes = 0, memory_used_bytes = 0, disk_free_bytes = 0;
  std::vector<std::pair<std::string, double>> phase_seconds;
  std::uint64_t subscribers = 0;
  std::uint64_t open_results = 0;                                 // kept open for questions
  std::vector<std::pair<std::string, std::uint64_t>> nodes = {};  // by state
  std::uint64_t nodes_lost = 0;                                   // since the start
  std::uint64_t bytes_between = 0, credit_waits = 0;  // sent between nodes, and waits for credit, since the start
  double certificate_end_s = 0;  // when this process's certificate for the cluster expires, since 1970; 0: no cluster
};

// Thread-safe.
class HealthBackend {
 public:
  virtual ~HealthBackend() = default;
  virtual ServiceFigures figures() const = 0;
  // Nothing when jobs can be accepted; else the reason: a full or read-only folder, or a thread that does not respond.
  virtual std::optional<std::string> unready() const = 0;
  // Set once the data folder belongs to another daemon or is gone: the reason why answers must not be trusted. Fast.
  virtual std::optional<std::string> lost() const = 0;
};

}  // namespace tessera::service

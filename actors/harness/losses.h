// What befalls the nodes of a run: some are killed, some stop for a while and go on after they have been given up, some
// are given up while they work, others join. Drawn in advance, by the step at which it happens.
#pragma once

#include <caf/all.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "actors/harness/harness.h"
#include "actors/harness/seeded_scheduler.h"
#include "actors/protocol.h"

namespace tessera {

class Losses {
 public:
  using Trace = std::function<void(const std::string&)>;
  // Makes another node, with this home.
  using Spawn = std::function<NodeHandle(NodeId)>;

  // At least one node is never lost.
  Losses(const HarnessFaults& faults, std::uint32_t nodes, std::mt19937_64& rng);

  // What is due.
  void at(std::uint64_t step, SeededScheduler& scheduler, const CoordinatorHandle& coordinator, const Spawn& spawn,
          const Trace& trace);
  // When nothing else can happen: the step of what comes next. None: all is over.
  std::optional<std::uint64_t> next_step() const;
  // Everybody runs again.
  void thaw(SeededScheduler& scheduler, std::uint32_t nodes) const;
  std::uint32_t nodes() const { return nodes_; }
  bool any() const { return any_; }

 private:
  enum class What : std::uint8_t { freeze, thaw, lost, join };
  struct Event {
    std::uint64_t step;
    What what;
    NodeId node;
  };
  void add(Event event);

  std::vector<Event> events_;  // by step
  std::uint32_t nodes_;        // that there have been
  bool any_ = false;
};

}  // namespace tessera

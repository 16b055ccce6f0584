#include "actors/harness/losses.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr std::uint64_t events_max = 4;

}  // namespace

Losses::Losses(const HarnessFaults& faults, std::uint32_t nodes, std::mt19937_64& rng) : nodes_(nodes) {
  enum class Kind : std::uint8_t { kill, pause, early, join };
  std::vector<Kind> kinds;
  if (faults.kill) kinds.push_back(Kind::kill);
  if (faults.pause) kinds.insert(kinds.end(), {Kind::pause, Kind::early});
  if (faults.join) kinds.push_back(Kind::join);
  if (kinds.empty()) return;
  std::vector<NodeId> there;
  for (std::uint32_t n = 0; n < nodes; ++n) there.push_back(NodeId{n});
  std::uint32_t numbered = nodes;
  std::uint64_t step = 0;
  for (std::uint64_t e = 1 + rng() % events_max; e > 0; --e) {
    step += rng() % 400;
    const Kind kind = kinds[rng() % kinds.size()];
    if (kind == Kind::join) {
      there.push_back(NodeId{numbered++});
      add({step, What::join, there.back()});
      continue;
    }
    if (there.size() < 2) continue;
    const auto chosen = there.begin() + static_cast<std::ptrdiff_t>(rng() % there.size());
    const NodeId node = *chosen;
    there.erase(chosen);
    if (kind != Kind::early) add({step, What::freeze, node});
    add({step + rng() % 150, What::lost, node});
    if (kind == Kind::pause) add({step + rng() % 400, What::thaw, node});
  }
}

void Losses::add(Event event) {
  any_ = true;
  // Those of one step in the order in which they were drawn: a node joins before it is lost.
  events_.insert(
      std::upper_bound(events_.begin(), events_.end(), event, [](const Event& a, const Event& b) { return a.step < b.step; }),
      event);
}

std::optional<std::uint64_t> Losses::next_step() const {
  if (events_.empty()) return std::nullopt;
  return events_.front().step;
}

void Losses::at(std::uint64_t step, SeededScheduler& scheduler, const CoordinatorHandle& coordinator,
                const Spawn& spawn, const Trace& trace) {
  while (!events_.empty() && events_.front().step <= step) {
    const Event event = events_.front();
    events_.erase(events_.begin());
    const auto tell = [&](const char* what) {
      if (trace) trace("node " + std::to_string(event.node.value) + what);
    };
    switch (event.what) {
      case What::freeze:
        tell(" stops");
        scheduler.freeze(event.node, true);
        break;
      case What::thaw:
        tell(" goes on");
        scheduler.freeze(event.node, false);
        break;
      case What::lost:
        tell(" is given up");
        caf::anon_send(coordinator, NodeLost{event.node});
        break;
      case What::join:
        tell(" joins");
        ++nodes_;
        caf::anon_send(coordinator, NodeJoined{caf::actor_cast<caf::actor>(spawn(event.node))});
        break;
    }
  }
}

void Losses::thaw(SeededScheduler& scheduler, std::uint32_t nodes) const {
  for (std::uint32_t n = 0; n < nodes; ++n) scheduler.freeze(NodeId{n}, false);
}

}  // namespace tessera

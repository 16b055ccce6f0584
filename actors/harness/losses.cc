#include "actors/harness/losses.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr std::uint64_t events_max = 4;
constexpr std::uint64_t steps_between = 400;  // at most; and until it is noticed:
constexpr std::uint64_t steps_unnoticed = 150;

}  // namespace

Losses::Losses(const HarnessFaults& faults, std::uint32_t nodes, std::mt19937_64& rng) {
  enum class Kind : std::uint8_t { kill, pause, early, join, coordinator };
  std::vector<Kind> kinds;
  if (faults.kill) kinds.push_back(Kind::kill);
  if (faults.pause) kinds.insert(kinds.end(), {Kind::pause, Kind::early});
  if (faults.join) kinds.push_back(Kind::join);
  if (faults.coordinator) kinds.push_back(Kind::coordinator);
  if (kinds.empty()) return;
  std::vector<NodeId> there;
  for (std::uint32_t n = 0; n < nodes; ++n) there.push_back(NodeId{n});
  std::uint32_t numbered = nodes;
  std::uint64_t step = 0, replaced = 0;
  for (std::uint64_t e = 1 + rng() % events_max; e > 0; --e) {
    step += rng() % steps_between;
    const std::uint64_t noticed = step + rng() % steps_unnoticed;
    const Kind kind = kinds[rng() % kinds.size()];
    if (kind == Kind::join) {
      there.push_back(NodeId{numbered++});
      add({step, What::join, there.back()});
      continue;
    }
    if (kind == Kind::coordinator) {
      step = std::max(step, replaced);  // one after the other
      replaced = step + rng() % steps_unnoticed;
      add({step, What::stop_coordinator, {}});
      add({replaced, What::take_over, {}});
      if (rng() % 2 == 0) add({replaced + rng() % steps_between, What::coordinators_go_on, {}});
      continue;
    }
    if (there.size() < 2) continue;
    const auto chosen = there.begin() + static_cast<std::ptrdiff_t>(rng() % there.size());
    const NodeId node = *chosen;
    there.erase(chosen);
    if (kind != Kind::early) add({step, What::stop, node});
    add({noticed, What::give_up, node});
    if (kind == Kind::pause) add({step + rng() % steps_between, What::go_on, node});
  }
}

// Those of one step in the order in which they were drawn: a node joins before it is lost.
void Losses::add(Event event) {
  any_ = true;
  events_.insert(std::upper_bound(events_.begin(), events_.end(), event,
                                  [](const Event& a, const Event& b) { return a.step < b.step; }),
                 event);
}

std::optional<std::uint64_t> Losses::next_step() const {
  if (events_.empty()) return std::nullopt;
  return events_.front().step;
}

void Losses::befall(std::uint64_t step, Misfortune& whom) {
  while (!events_.empty() && events_.front().step <= step) {
    const Event event = events_.front();
    events_.erase(events_.begin());
    switch (event.what) {
      case What::stop:
        whom.stop(event.node);
        break;
      case What::go_on:
        whom.go_on(event.node);
        break;
      case What::give_up:
        whom.give_up(event.node);
        break;
      case What::join:
        whom.join(event.node);
        break;
      case What::stop_coordinator:
        whom.stop_coordinator();
        break;
      case What::take_over:
        whom.take_over();
        break;
      case What::coordinators_go_on:
        whom.coordinators_go_on();
        break;
    }
  }
}

}  // namespace tessera

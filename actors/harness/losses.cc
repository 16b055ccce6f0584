#include "actors/harness/losses.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t events_max = 4;
constexpr std::uint64_t steps_between = 400;    // at most, from one event to the next
constexpr std::uint64_t steps_unnoticed = 150;  // at most, until a loss is noticed

}  // namespace

Losses::Losses(const HarnessFaults& faults, std::uint32_t nodes, std::mt19937_64& rng) : rng_(rng), numbered_(nodes) {
  enum class Kind : std::uint8_t { kill, pause, early, join, leave, coordinator, last, all };
  std::vector<Kind> kinds;
  if (faults.kill) kinds.push_back(Kind::kill);
  if (faults.pause) kinds.insert(kinds.end(), {Kind::pause, Kind::early});
  if (faults.join) kinds.push_back(Kind::join);
  if (faults.leave) kinds.push_back(Kind::leave);
  if (faults.coordinator) kinds.push_back(Kind::coordinator);
  if (faults.last) kinds.push_back(Kind::last);
  if (faults.all) kinds.push_back(Kind::all);
  if (kinds.empty()) return;
  for (std::uint32_t n = 0; n < nodes; ++n) there_.push_back({NodeId{n}});
  std::uint64_t step = 0;
  for (std::uint64_t e = 1 + draw(events_max); e > 0; --e) {
    step += draw(steps_between);
    switch (kinds[draw(kinds.size())]) {
      case Kind::kill:
        lose_one(step, true, false);
        break;
      case Kind::pause:
        lose_one(step, true, true);
        break;
      case Kind::early:
        lose_one(step, false, false);
        break;
      case Kind::join:
        come(step);
        break;
      case Kind::leave:
        leave_one(step);
        break;
      case Kind::coordinator:
        step = std::max(step, replaced_);  // coordinators are replaced one after the other
        replace_coordinator(step);
        if (draw(2) == 0) add({replaced_ + draw(steps_between), What::coordinators_go_on, {}});
        break;
      case Kind::last:
        lose_last(step);
        break;
      case Kind::all:
        step = std::max(step, replaced_);
        lose_all(step, faults.coordinator && draw(2) == 0);
        break;
    }
  }
}

void Losses::come(std::uint64_t step) {
  there_.push_back({NodeId{numbered_++}, step});
  add({step, What::join, there_.back().node});
}

Losses::There Losses::take_any() {
  const auto chosen = there_.begin() + static_cast<std::ptrdiff_t>(draw(there_.size()));
  const There one = *chosen;
  there_.erase(chosen);
  return one;
}

// Loses any node, but never the last one.
void Losses::lose_one(std::uint64_t step, bool stops, bool goes_on) {
  const std::uint64_t unnoticed = draw(steps_unnoticed);
  if (there_.size() < 2) return;
  const auto [node, since] = take_any();
  step = std::max(step, since);
  if (stops) add({step, What::stop, node});
  add({step + unnoticed, What::give_up, node});
  if (goes_on) add({step + draw(steps_between), What::go_on, node});
}

// When the last node leaves, another one comes before, meanwhile or after.
void Losses::leave_one(std::uint64_t step) {
  const bool last = there_.size() == 1;
  const There one = take_any();
  if (last) come(step + draw(2 * steps_unnoticed));
  add({std::max(step, one.since), What::leave, one.node});
}

// Another node comes before, meanwhile or after. It may be opening its share just then.
void Losses::lose_last(std::uint64_t step) {
  const std::vector<There> lost = std::exchange(there_, {});
  for (const There& one : lost) step = std::max(step, one.since);
  if (draw(2) == 0) add({step + draw(2 * steps_unnoticed), What::join_in_vain, NodeId{numbered_++}});
  come(step + draw(2 * steps_unnoticed));
  for (const auto& [node, since] : lost) {
    const std::uint64_t stops = step + draw(steps_unnoticed);
    add({stops, What::stop, node});
    add({stops + draw(steps_unnoticed), What::give_up, node});
  }
}

// As many nodes come as there were.
void Losses::lose_all(std::uint64_t step, bool coordinator) {
  const std::vector<There> lost = std::exchange(there_, {});
  for (const There& one : lost) step = std::max(step, one.since);
  for (const auto& [node, since] : lost) {
    add({step, What::stop, node});
    add({coordinator ? step : step + draw(steps_unnoticed), coordinator ? What::lose : What::give_up, node});
    come(step + draw(steps_unnoticed));
  }
  // Added after the losses, so that the new coordinator does not begin with the lost nodes.
  if (coordinator) replace_coordinator(step);
}

void Losses::replace_coordinator(std::uint64_t step) {
  replaced_ = step + draw(steps_unnoticed);
  add({step, What::stop_coordinator, {}});
  add({replaced_, What::take_over, {}});
}

// Events of one step keep the order in which they were drawn, so a node joins before it is lost.
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
      case What::leave:
        whom.leave(event.node);
        break;
      case What::join_in_vain:
        whom.join_in_vain(event.node);
        break;
      case What::lose:
        whom.lose(event.node);
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

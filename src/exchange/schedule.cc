#include "src/exchange/schedule.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "src/base/check.h"

namespace tessera {
namespace {

constexpr std::uint64_t ahead_part = 256;  // a permit ahead of a free thread gets at most 1/256 of the memory
constexpr TileId nobody{~std::uint32_t{0}};

}  // namespace

Schedule::Schedule(const ScheduleOptions& options, const std::vector<std::uint64_t>& weights) : options_(options) {
  for (std::uint32_t t = 0; t < weights.size(); ++t) {
    if (weights[t] > 0) add(TileId{t}, weights[t]);
  }
}

void Schedule::set_stored(TileId tile) {
  const auto found = tiles_.find(tile);
  if (found == tiles_.end()) return;
  unlink(tile);
  found->second.is_stored = true;
  link(tile);
}

void Schedule::enter(Mode mode) {
  const bool again = mode_ == Mode::settling && mode == Mode::exchanging;
  check_read(mode >= mode_ || again, "the modes of a schedule follow one another");
  mode_ = mode;
  pending_.clear();
  for (auto& [id, tile] : tiles_) {
    if (again) tile.settled = false;
    link(id);
  }
}

void Schedule::add(TileId id, std::uint64_t weight) {
  Tile& tile = tiles_[id];
  check_read(tile.residency == Residency::gone, "a tile is here once");
  check_read(mode_ != Mode::settling, "what has to begin is not settled");
  tile = {};
  tile.weight = weight;
  tile.residency = Residency::fresh;
  ++fresh_;
  next_fresh_ = std::min(next_fresh_, id);
  link(id);
}

std::vector<TileId> Schedule::release(std::uint64_t weight) {
  std::vector<TileId> released;
  for (auto next = tiles_.end(); next != tiles_.begin() && weight > 0;) {
    auto& [id, tile] = *--next;
    if (tile.residency != Residency::fresh || tile.working || tile.is_stored) continue;
    weight -= std::min(weight, tile.weight);
    unlink(id);
    set_memory(tile, 0);
    --fresh_;
    released.push_back(id);
    next = tiles_.erase(next);
  }
  return released;
}

// Updates are counted, too, because empty updates must be processed as well.
Schedule::Ready Schedule::rank(TileId id, const Tile& tile) {
  return {~tile.mail.hops, tile.mail.bytes + tile.mail.updates, id};
}

bool Schedule::pending(const Tile& tile) const {
  if (mode_ == Mode::settling) {
    return !tile.settled &&
           (tile.residency == Residency::awake || (options_.settle_asleep && tile.residency == Residency::asleep));
  }
  if (mode_ == Mode::handing) return tile.residency == Residency::awake || tile.residency == Residency::asleep;
  if (mode_ != Mode::collecting) return false;
  if (tile.residency == Residency::awake) return true;  // is finished, or at least dropped
  return !tile.is_stored && (tile.residency == Residency::fresh || tile.residency == Residency::asleep);
}

void Schedule::unlink(TileId t) {
  const Tile& tile = tiles_.at(t);
  if (tile.working) return;
  if (tile.residency == Residency::awake && tile.mail.updates > 0) {
    ready_.erase(rank(t, tile));
    awake_.erase({tile.mail.bytes, t});
  }
  quiet_.erase(t);
  called_.erase(t);
  pending_.erase({tile.residency != Residency::awake, t});
}

void Schedule::link(TileId t) {
  const Tile& tile = tiles_.at(t);
  if (tile.working) return;
  if (tile.residency == Residency::awake && tile.mail.updates > 0) {
    ready_.insert(rank(t, tile));
    awake_.insert({tile.mail.bytes, t});
  }
  if (tile.residency == Residency::awake && tile.mail.updates == 0 && !unbuilt(tile)) quiet_.insert(t);
  if (tile.residency == Residency::asleep && tile.mail.updates > 0) called_.insert(t);
  if (pending(tile)) pending_.insert({tile.residency != Residency::awake, t});
}

void Schedule::set_memory(Tile& tile, std::uint64_t bytes) {
  memory_ += bytes - tile.memory;
  tile.memory = bytes;
}

void Schedule::note_mail(TileId id, const Waiting& waiting) {
  const auto found = tiles_.find(id);
  if (found == tiles_.end()) return;
  Tile& tile = found->second;
  if (tile.working || tile.residency == Residency::gone) return;
  unlink(id);
  set_memory(tile, tile.memory - tile.mail.memory + waiting.memory);
  tile.mail = waiting;
  link(id);
}

void Schedule::note_done(TileId id, Work work, std::uint64_t bytes, const Waiting& waiting, std::uint64_t storing) {
  Tile& tile = tiles_.at(id);
  check_read(tile.working, "only granted work is done");
  if (std::exchange(tile.falling_asleep, false)) freeing_ -= tile.memory;
  tile.working = false;
  --working_;
  tile.mail = waiting;
  const bool woken = tile.residency == Residency::asleep;
  switch (work) {
    case Work::begin:
      tile.residency = Residency::awake;
      --fresh_;
      break;
    case Work::step:
      tile.residency = Residency::awake;
      break;
    case Work::sleep:
      tile.residency = Residency::asleep;
      ++asleep_;
      ++sleeps_;
      break;
    case Work::settle:
      tile.residency = Residency::awake;
      tile.settled = true;
      break;
    case Work::finish:
      if (tile.residency == Residency::fresh) --fresh_;
      tile.residency = Residency::storing;
      tile.storing = storing;
      ++storing_;
      storing_bytes_ += storing;
      break;
    case Work::drop:
    case Work::hand_over:
      tile.residency = Residency::gone;
      break;
  }
  if (woken) --asleep_;
  if (work != Work::sleep) tile.held = bytes;
  set_memory(tile, bytes + waiting.memory + tile.storing);
  link(id);
}

void Schedule::note_stored(TileId id) {
  Tile& tile = tiles_.at(id);
  check_read(tile.residency == Residency::storing, "only what was collected is stored");
  set_memory(tile, tile.memory - tile.storing);
  storing_bytes_ -= std::exchange(tile.storing, 0);
  tile.residency = Residency::gone;
  tile.is_stored = true;
  --storing_;
}

void Schedule::abandon(TileId id) {
  const auto found = tiles_.find(id);
  if (found == tiles_.end()) return;
  Tile& tile = found->second;
  unlink(id);
  if (tile.working) --working_;
  if (std::exchange(tile.falling_asleep, false)) freeing_ -= tile.memory;
  if (tile.residency == Residency::storing) {
    --storing_;
    storing_bytes_ -= std::exchange(tile.storing, 0);
  }
  if (tile.residency == Residency::fresh) --fresh_;
  if (tile.residency == Residency::asleep) --asleep_;
  tile.working = false;
  tile.residency = Residency::gone;
  tile.mail = {};
  set_memory(tile, 0);
}

bool Schedule::idle() const {
  if (working_ + storing_ > 0) return false;
  switch (mode_) {
    case Mode::exchanging:
      return fresh_ == 0 && ready_.empty() && called_.empty();
    case Mode::settling:
    case Mode::collecting:
    case Mode::handing:
      return pending_.empty();
    case Mode::suspending:
      return !to_sleep(nobody);
    case Mode::stopping:
      return true;
  }
  return true;
}

std::optional<Schedule::Permit> Schedule::next() {
  if (working_ >= options_.threads + options_.threads || mode_ == Mode::stopping) return std::nullopt;
  if (mode_ == Mode::suspending) {
    if (ahead()) return std::nullopt;
    while (const auto t = to_sleep(nobody)) {
      const std::uint64_t held = tiles_.at(*t).held;
      if (suspended_bytes_ + held > options_.suspend_bytes) {
        abandon(*t);
        continue;
      }
      suspended_bytes_ += held;
      return put_to_sleep(*t);
    }
    return std::nullopt;
  }
  if (mode_ == Mode::handing) return hand_next();
  if (mode_ == Mode::settling) {
    if (pending_.empty()) return std::nullopt;
    const TileId t = pending_.begin()->second;
    const Tile& tile = tiles_.at(t);
    if (tile.residency == Residency::awake) return permit(t, Work::settle, tile.memory);
    return grant_in_room(t, Work::settle, tile.memory + waking_bytes(tile));
  }
  if (mode_ == Mode::collecting) {
    // Tiles that wait for the disk may not take the memory of others, unless they are small.
    const bool many = storing_ > options_.threads && storing_bytes_ > options_.memory_bytes / 16;
    if (pending_.empty() || many) return std::nullopt;
    const TileId t = pending_.begin()->second;
    const Tile& tile = tiles_.at(t);
    if (tile.is_stored) return permit(t, Work::drop, tile.memory);
    const std::uint64_t before = tile.residency == Residency::fresh    ? options_.begin_bytes * tile.weight
                                 : tile.residency == Residency::asleep ? tile.held
                                                                       : 0;
    return grant_in_room(t, Work::finish, tile.memory + before + options_.collect_bytes * tile.weight);
  }
  auto fresh = tiles_.lower_bound(next_fresh_);
  while (fresh != tiles_.end() && (fresh->second.residency != Residency::fresh || fresh->second.working)) ++fresh;
  next_fresh_ = fresh == tiles_.end() ? nobody : fresh->first;
  if (fresh != tiles_.end()) {
    const auto& [t, tile] = *fresh;
    const std::uint64_t needed = tile.memory + options_.begin_bytes * tile.weight;
    if (!fits(t, needed) && !ready_.empty()) return step_awake();
    sweep_ = t;
    return grant_in_room(t, Work::begin, needed);
  }
  return ready_.empty() ? wake_next() : step_awake();
}

// The image of a sleeping tile passes through memory.
std::optional<Schedule::Permit> Schedule::hand_next() {
  if (ahead() || pending_.empty()) return std::nullopt;
  const TileId t = pending_.begin()->second;
  const Tile& tile = tiles_.at(t);
  const std::uint64_t needed = tile.memory + sleeping_bytes(tile);
  if (tile.residency == Residency::asleep && working_ > 0 && !fits(t, needed)) return std::nullopt;
  return permit(t, Work::hand_over, needed);
}

// REQUIRES: a tile in memory with mail is idle.
std::optional<Schedule::Permit> Schedule::step_awake() {
  const TileId t = std::get<2>(*ready_.begin());
  const Tile& tile = tiles_.at(t);
  return grant_in_room(t, Work::step, tile.memory + growth(tile));
}

bool Schedule::unbuilt(const Tile& tile) const {
  return tile.residency == Residency::awake && tile.held < options_.unbuilt_bytes;
}

std::uint64_t Schedule::growth(const Tile& tile) const {
  const std::uint64_t building = unbuilt(tile) ? options_.begin_bytes * tile.weight : 0;
  return building + static_cast<std::uint64_t>(options_.mail_growth * static_cast<double>(tile.mail.bytes));
}

std::optional<Schedule::Permit> Schedule::wake_next() {
  const auto t = next_of_sweep();
  if (!t) return std::nullopt;
  sweep_ = *t;
  const Tile& tile = tiles_.at(*t);
  return grant_in_room(*t, Work::step, tile.memory + waking_bytes(tile) + growth(tile));
}

// Returns the next tile of the sweep, of the sleeping tiles with mail. The sweep turns where it ends.
std::optional<TileId> Schedule::next_of_sweep() {
  for (int turns = 0; turns < 2; ++turns) {
    if (sweeping_back_) {
      if (const auto after = called_.upper_bound(sweep_); after != called_.begin()) return *std::prev(after);
    } else {
      if (const auto next = called_.lower_bound(sweep_); next != called_.end()) return *next;
    }
    sweeping_back_ = !sweeping_back_;
  }
  return std::nullopt;
}

// Returns the tile in memory that is to sleep, but never `but`: of those without mail the farthest from the sweep, in
// the order of tiles; if all have mail, the one with the least.
std::optional<TileId> Schedule::to_sleep(TileId but) const {
  const auto distance = [&](TileId t) { return t < sweep_ ? sweep_.value - t.value : t.value - sweep_.value; };
  auto first = quiet_.begin();
  auto last = quiet_.rbegin();
  if (first != quiet_.end() && *first == but) ++first;
  if (last != quiet_.rend() && *last == but) ++last;
  if (first != quiet_.end() && last != quiet_.rend()) return distance(*first) > distance(*last) ? *first : *last;
  for (const auto& [bytes, t] : awake_) {
    if (t != but && !unbuilt(tiles_.at(t))) return t;
  }
  return std::nullopt;
}

bool Schedule::fits(TileId t, std::uint64_t needed, std::uint64_t freed) const {
  return memory_ - freed - tiles_.at(t).memory + needed <= options_.memory_bytes;
}

// Gives the permit, or makes room by putting another tile to sleep, or waits until some work ends. Some work is always
// under way: with nothing else in memory a tile may exceed the budget. A permit ahead of a free thread is for small
// work only, because the tile holds its memory while it waits.
std::optional<Schedule::Permit> Schedule::grant_in_room(TileId t, Work work, std::uint64_t needed) {
  if (ahead() && (!fits(t, needed) || needed > options_.memory_bytes / ahead_part)) return std::nullopt;
  if (fits(t, needed)) return permit(t, work, needed);
  if (fits(t, needed, freeing_)) return std::nullopt;  // there will be room in a moment
  if (const auto other = to_sleep(t)) return put_to_sleep(*other);
  if (working_ + storing_ > 0) return std::nullopt;
  return permit(t, work, needed);
}

std::optional<Schedule::Permit> Schedule::put_to_sleep(TileId t) {
  const Tile& tile = tiles_.at(t);
  return permit(t, Work::sleep, tile.memory + sleeping_bytes(tile));
}

std::optional<Schedule::Permit> Schedule::permit(TileId t, Work work, std::uint64_t needed) {
  unlink(t);
  Tile& tile = tiles_.at(t);
  set_memory(tile, needed);
  tile.working = true;
  ++working_;
  tile.falling_asleep = work == Work::sleep;
  if (tile.falling_asleep) freeing_ += tile.memory;
  return Permit{t, work};
}

}  // namespace tessera

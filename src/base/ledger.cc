#include "src/base/ledger.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

// The system is asked for the free bytes once in so many written bytes.
constexpr std::uint64_t look_every_bytes = std::uint64_t{16} << 20;

thread_local Ledger* current = nullptr;

Error beyond(const char* what, const Ledger::Bound& bound) {
  return error(Errc::memory, std::string("the job needs more ") + what + " than " + bound.name + " allows");
}

}  // namespace

Ledger* Ledger::of_thread() { return current; }

Status Ledger::draw_write(std::uint64_t bytes) { return current == nullptr ? success() : current->write(bytes); }

Status Ledger::draw_memory(std::uint64_t bytes) { return current == nullptr ? success() : current->hold(bytes); }

Status Ledger::draw_files(std::uint64_t files) { return current == nullptr ? success() : current->name_files(files); }

std::stop_token Ledger::token_of_thread() { return current == nullptr ? std::stop_token() : current->token(); }

std::optional<Error> Ledger::reason_of_thread() { return current == nullptr ? std::nullopt : current->reason(); }

Ledger::Use::Use(Ledger* ledger) : before_(std::exchange(current, ledger)) {}

Ledger::Use::~Use() { current = before_; }

Status Ledger::go_on() const {
  if (!stop_.stop_requested()) return success();
  const auto why = reason();
  return why ? *why : error(Errc::interrupted, "was stopped");
}

void Ledger::stop(Error why) {
  {
    const std::lock_guard lock(mutex_);
    if (!reason_ && !stop_.stop_requested()) reason_ = std::move(why);
  }
  stop_.request_stop();
}

std::optional<Error> Ledger::reason() const {
  const std::lock_guard lock(mutex_);
  return reason_;
}

Status Ledger::refuse(Error why) {
  stop(why);
  return why;
}

Status Ledger::take(std::atomic<std::uint64_t>& from, std::uint64_t amount, const Bound& bound, const char* what) {
  BOOST_OUTCOME_TRYV(go_on());
  std::uint64_t before = from;
  do {
    if (amount > bound.most - std::min(before, bound.most)) return refuse(beyond(what, bound));
  } while (!from.compare_exchange_weak(before, before + amount));
  return success();
}

Status Ledger::hold(std::uint64_t bytes) { return take(held_, bytes, bounds_.memory, "memory"); }

Status Ledger::name_files(std::uint64_t files) { return take(files_, files, bounds_.files, "files"); }

Status Ledger::write(std::uint64_t bytes) {
  if (bytes == 0) return go_on();
  BOOST_OUTCOME_TRYV(take(written_, bytes, bounds_.disk, "disk"));
  BOOST_OUTCOME_TRYV(look_at_disk(bytes));
  return go_on();
}

Status Ledger::written_by_others(std::uint64_t bytes) {
  BOOST_OUTCOME_TRYV(go_on());
  std::uint64_t before = others_;
  while (bytes > before && !others_.compare_exchange_weak(before, bytes)) {
  }
  if (bytes > bounds_.disk.most) return refuse(beyond("disk", bounds_.disk));
  return look_at_disk(0);
}

Status Ledger::look_at_disk(std::uint64_t bytes) {
  if (!bounds_.free_bytes) return success();
  const std::uint64_t now = written_ + others_, looked = looked_at_;
  // The disk is checked at the first write, so that a small job on a full disk is refused, too, and whenever other
  // processes write, which report seldom.
  if (bytes > 0 && looked > 0 && now - std::min(now, looked) < look_every_bytes) return success();
  looked_at_ = std::max<std::uint64_t>(now, 1);
  const std::uint64_t free = bounds_.free_bytes();
  if (free >= bytes && free - bytes >= bounds_.reserve_bytes) return success();
  return refuse(error(Errc::io, "the disk has " + std::to_string(free >> 20) + " MiB left, but limits.reserve keeps " +
                                    std::to_string(bounds_.reserve_bytes >> 20) +
                                    " MiB free: " + std::generic_category().message(ENOSPC)));
}

}  // namespace tessera

#include "src/track/pulses.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>
#include <utility>

#include "src/base/random.h"

namespace tessera {

namespace {

std::uint64_t hash_of(std::uint32_t line, double time) {
  return mixed_bits(std::bit_cast<std::uint64_t>(time) ^ mixed_bits(line));
}

}  // namespace

Pulses::Pulses(const std::vector<Attribute>& schema, std::size_t most) : most_(most) {
  line_ = column_of(schema, "point_source_id");
  for (const auto& [name, field] :
       {std::pair("gps_time", &time_), std::pair("return_number", &number_), std::pair("number_of_returns", &count_)}) {
    const auto found = column_of(schema, name);
    if (!found && missing_.empty()) missing_ = name;
    if (found) *field = *found;
  }
}

void Pulses::add(const Point& at, const std::byte* row) {
  const double number = number_.value(row), count = count_.value(row);
  if (!(count > 1) || (number != 1 && number != count)) return;
  const double line = line_ ? line_->value(row) : 0;
  const double time = time_.value(row);
  if (!std::isfinite(time) || !(line >= 0 && line < 4e9)) return;
  keep({static_cast<std::uint32_t>(line), number == 1, time, at});
}

void Pulses::add(const Pulses& others) {
  for (const Return& one : others.returns_) keep(one);
  // Those that the others have not kept must not be here either.
  if (others.limit_ < limit_) {
    limit_ = others.limit_;
    std::erase_if(returns_, [&](const Return& one) { return hash_of(one.line, one.time) > limit_; });
  }
}

// The limit is the first half of a half of all hashes with which not too many are kept, in whatever order they come.
void Pulses::keep(const Return& one) {
  if (hash_of(one.line, one.time) > limit_) return;
  returns_.push_back(one);
  while (returns_.size() > most_) {
    limit_ /= 2;
    std::erase_if(returns_, [&](const Return& other) { return hash_of(other.line, other.time) > limit_; });
  }
}

std::vector<Pulse> Pulses::take() {
  const auto key = [](const Return& r) { return std::tuple(r.line, r.time, !r.is_first, r.at); };
  std::sort(returns_.begin(), returns_.end(), [&](const Return& a, const Return& b) { return key(a) < key(b); });
  // The same point may come twice, as in files that overlap.
  returns_.erase(
      std::unique(returns_.begin(), returns_.end(), [&](const Return& a, const Return& b) { return key(a) == key(b); }),
      returns_.end());
  std::vector<Pulse> pulses;
  for (std::size_t i = 0, end = 0; i < returns_.size(); i = end) {
    const Return& one = returns_[i];
    while (end < returns_.size() && returns_[end].line == one.line && returns_[end].time == one.time) ++end;
    if (end - i == 2 && one.is_first && !returns_[i + 1].is_first)
      pulses.push_back({one.line, one.time, one.at, returns_[i + 1].at});
  }
  returns_ = {};
  return pulses;
}

}  // namespace tessera

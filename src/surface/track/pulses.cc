#include "src/surface/track/pulses.h"

#include <cmath>
#include <tuple>
#include <utility>

namespace tessera {

Pulses::Pulses(const std::vector<Attribute>& schema, std::size_t most) : returns_(most) {
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
  returns_.add({static_cast<std::uint32_t>(line), number == 1, time, at});
}

void Pulses::add(const Pulses& others) { returns_.add(others.returns_); }

std::vector<Pulse> Pulses::take() {
  const std::vector<Return> returns =
      returns_.take([](const Return& r) { return std::tuple(r.line, r.time, !r.is_first, r.at); });
  std::vector<Pulse> pulses;
  for (std::size_t i = 0, end = 0; i < returns.size(); i = end) {
    const Return& one = returns[i];
    while (end < returns.size() && returns[end].line == one.line && returns[end].time == one.time) ++end;
    if (end - i == 2 && one.is_first && !returns[i + 1].is_first)
      pulses.push_back({one.line, one.time, one.at, returns[i + 1].at});
  }
  return pulses;
}

}  // namespace tessera

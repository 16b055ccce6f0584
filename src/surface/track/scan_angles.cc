#include "src/surface/track/scan_angles.h"

#include <cmath>
#include <tuple>
#include <utility>

namespace tessera {

namespace {
constexpr double angle_max = 80;  // beyond it the tangent says nothing
}

ScanAngles::ScanAngles(const std::vector<Attribute>& schema, std::size_t most) : points_(most) {
  line_ = column_of(schema, "point_source_id");
  for (const auto& [name, field] : {std::pair("gps_time", &time_), std::pair("scan_angle", &angle_)}) {
    const auto found = column_of(schema, name);
    if (!found && missing_.empty()) missing_ = name;
    if (found) *field = *found;
  }
}

void ScanAngles::add(const Point& at, const std::byte* row) {
  const double degrees = angle_.value(row), time = time_.value(row);
  const double line = line_ ? line_->value(row) : 0;
  if (!std::isfinite(time) || !(line >= 0 && line < 4e9) || !(std::abs(degrees) <= angle_max)) return;
  points_.add({static_cast<std::uint32_t>(line), time, degrees, at});
}

std::vector<AngledPoint> ScanAngles::take() {
  return points_.take([](const AngledPoint& p) { return std::tuple(p.line, p.time, p.at, p.degrees); });
}

}  // namespace tessera

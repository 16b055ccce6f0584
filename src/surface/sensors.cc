#include "src/surface/sensors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "src/surface/energy.h"

namespace tessera::surface {

namespace {

constexpr std::array<std::string_view, 3> origin_names{"x_origin", "y_origin", "z_origin"},
    normal_names{"nx", "ny", "nz"};
// The vote of a return with others behind it: leaves and twigs.
constexpr std::uint32_t intermediate_vote = full_vote / 8;

double squared(const Point& a, const Point& b) {
  const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
  return x * x + y * y + z * z;
}

}  // namespace

Status Sensors::find(const std::vector<Attribute>& schema, bool wanted) {
  for (const auto& [names, how] : {std::pair(origin_names, How::origin), std::pair(normal_names, How::normal)}) {
    fields_.clear();
    for (const std::string_view name : names)
      if (const auto field = column_of(schema, name)) fields_.push_back(*field);
    if (fields_.size() < names.size()) continue;
    how_ = how;
    used_ = how == How::origin ? "sensors: of each point, from x_origin, y_origin, z_origin"
                               : "sensors: in the direction of each point's normal nx, ny, nz";
    return success();
  }
  fields_.clear();
  if (wanted)
    return error(Errc::usage,
                 "the points have neither x_origin, y_origin and z_origin nor nx, ny and nz, which would tell where "
                 "their sensors were");
  return success();
}

// Finds the columns of a point's time and, if there is one, of its flight line, in this order.
Status Sensors::find_times(const std::vector<Attribute>& schema) {
  const auto time = column_of(schema, "gps_time"), line = column_of(schema, "point_source_id");
  if (!time) return error(Errc::usage, "the points have no gps_time, by which a track tells where their sensor was");
  if (track_->tells_lines() && !line)
    return error(Errc::usage,
                 "the track has several flight lines, and the points have no point_source_id to tell theirs");
  fields_ = {*time};
  if (line) fields_.push_back(*line);
  how_ = How::track;
  return success();
}

Status Sensors::use_estimate(const EstimatedTrack& estimate, const std::vector<Attribute>& schema) {
  std::size_t refused = 0;
  for (const TrackLine& line : estimate.lines) refused += line.refused.empty() ? 0 : 1;
  if (refused == estimate.lines.size()) {
    if (by_angles_)
      return error(Errc::usage, "the points' scan angles do not tell where their sensors were" +
                                    (refused == 0 ? std::string()
                                                  : ": of flight line " + std::to_string(estimate.lines[0].line) +
                                                        ", " + estimate.lines[0].refused));
    used_ =
        "sensors: straight above each point, as neither pulses with several returns nor scan angles tell where the "
        "scanner was";
    return success();
  }
  track_ = std::make_shared<const Track>(estimate.track);
  BOOST_OUTCOME_TRYV(find_times(schema));
  double median = 0, height = 0;
  bool by_pulses = false, by_angles = false;
  for (const TrackLine& line : estimate.lines) {
    if (!line.refused.empty()) continue;
    (line.from == TrackLine::From::pulses ? by_pulses : by_angles) = true;
    median = std::max(median, line.median_degrees);
    height = std::max(height, line.height);
  }
  const std::string where = !by_angles  ? "where pulses with several returns come together"
                            : by_pulses ? "where pulses with several returns come together, or scan angles say"
                                        : "where scan angles say";
  const auto whole = [](double value) { return std::to_string(static_cast<long long>(value + 0.5)); };
  used_ = "sensors: " + where + ", " + whole(height) + " above the points, off by " +
          std::to_string(static_cast<int>(median * 100 + 0.5)) + "/100 of a degree at the median";
  if (refused > 0)
    used_ += "; straight above the points of " + std::to_string(refused) + " of " +
             std::to_string(estimate.lines.size()) + " flight lines, which do not tell";
  return success();
}

Result<Sensors> Sensors::make(const SensorOptions& options, const std::vector<Attribute>& schema,
                              const Bounds& bounds) {
  Sensors sensors;
  const double size = std::sqrt(squared(bounds.lo, bounds.hi));
  sensors.far_ = 4 * size + 1;
  sensors.top_ = bounds.hi.z + sensors.far_;
  if (!std::isfinite(sensors.top_))
    return error(Errc::usage, "the points are too far apart for rays: their coordinates are beyond 1e150");
  switch (options.kind) {
    case SensorOptions::Kind::positions:
      if (options.positions.empty()) return error(Errc::usage, "no position of a sensor is given");
      for (const Point& at : options.positions)
        if (!is_finite(at)) return error(Errc::usage, "a position of a sensor is not finite");
      sensors.how_ = How::positions;
      sensors.positions_ = options.positions;
      sensors.used_ = options.positions.size() == 1
                          ? "sensors: one position for all points"
                          : "sensors: of " + std::to_string(options.positions.size()) + " positions the nearest";
      return sensors;
    case SensorOptions::Kind::fields: {
      BOOST_OUTCOME_TRYV(sensors.find(schema, true));
      return sensors;
    }
    case SensorOptions::Kind::track: {
      sensors.track_ = options.track;
      sensors.else_above_ = options.else_above;
      if (!sensors.track_) return error(Errc::usage, "no track is given");
      sensors.used_ = "sensors: by the track, at each point's gps_time";
      BOOST_OUTCOME_TRYV(sensors.find_times(schema));
      return sensors;
    }
    case SensorOptions::Kind::angles: {
      for (const char* name : {"scan_angle", "gps_time"})
        if (!column_of(schema, name))
          return error(Errc::usage, std::string("the points have no ") + name +
                                        ", which is needed to find their sensors from scan angles");
      sensors.else_above_ = sensors.by_angles_ = true;
      return sensors;
    }
    case SensorOptions::Kind::automatic: {
      sensors.else_above_ = true;
      BOOST_OUTCOME_TRYV(sensors.find(schema, false));
      if (!sensors.fields_.empty()) return sensors;
      sensors.used_ = "sensors: straight above each point, as no attribute tells where they were";
      return sensors;
    }
    case SensorOptions::Kind::vertical:
      sensors.used_ = "sensors: straight above each point";
      return sensors;
  }
  return error(Errc::internal, "the kind of sensors is not known");
}

SensorOptions Sensors::found() const {
  SensorOptions options{.kind = SensorOptions::Kind::vertical, .positions = positions_, .track = track_};
  switch (how_) {
    case How::vertical:
      break;
    case How::origin:
    case How::normal:
      options.kind = SensorOptions::Kind::fields;
      break;
    case How::positions:
      options.kind = SensorOptions::Kind::positions;
      break;
    case How::track:
      options.kind = SensorOptions::Kind::track;
      options.else_above = else_above_;
      break;
  }
  return options;
}

Point Sensors::read(const std::byte* row) const {
  Point at;
  for (int axis = 0; axis < 3; ++axis) at[axis] = fields_[static_cast<std::size_t>(axis)].value(row);
  return at;
}

Result<std::optional<Sensors::Sensor>> Sensors::of(const Point& p, PointId id, const std::byte* row) const {
  Point sensor;
  bool guessed = false;
  switch (how_) {
    case How::vertical:
      sensor = {p.x, p.y, top_};
      break;
    case How::origin:
      sensor = read(row);
      break;
    case How::normal: {
      const Point n = read(row);
      const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
      if (!std::isfinite(length) || length == 0) return std::optional<Sensor>();
      const double scale = far_ / length;
      sensor = {p.x + n.x * scale, p.y + n.y * scale, p.z + n.z * scale};
      break;
    }
    case How::track: {
      const double time = fields_[0].value(row);
      const double line = fields_.size() > 1 ? fields_[1].value(row) : 0;
      const auto at = line >= 0 && line < 4e9 ? track_->at(static_cast<std::uint32_t>(line), time) : std::nullopt;
      if (!at && !else_above_) return std::optional<Sensor>();
      guessed = !at;
      sensor = at.value_or(Point{p.x, p.y, top_});
      break;
    }
    case How::positions: {
      sensor = *std::min_element(positions_.begin(), positions_.end(),
                                 [&](const Point& a, const Point& b) { return squared(p, a) < squared(p, b); });
      break;
    }
  }
  if (!is_finite(sensor)) return std::optional<Sensor>();
  if (sensor == p) return error(Errc::usage, "point " + to_string(id) + " is where its sensor is said to be");
  return std::optional(Sensor{sensor, guessed});
}

Solidity::Solidity(const std::vector<Attribute>& schema) {
  const auto number = column_of(schema, "return_number"), count = column_of(schema, "number_of_returns");
  if (!number || !count) return;
  number_ = number;
  count_ = count;
}

std::uint32_t Solidity::vote(const std::byte* row) const {
  if (!number_) return full_vote;
  return number_->value(row) < count_->value(row) ? intermediate_vote : full_vote;
}

}  // namespace tessera::surface

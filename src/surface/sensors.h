// From where a point was seen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/attribute_value.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/surface/track/estimate.h"
#include "src/surface/track/track.h"

namespace tessera {

struct SensorOptions {
  enum class Kind : std::uint8_t {
    automatic,  // from the fields, if there are any; else from pulses or scan angles; else vertical
    vertical,   // straight above the point
    fields,     // x_origin, y_origin, z_origin of the point, or the direction nx, ny, nz of its normal
    positions,  // the nearest of some positions
    track,      // where the scanner was at the point's gps_time
    angles      // from the points' scan angles; else vertical
  };
  Kind kind = Kind::automatic;
  std::string text = "auto";  // what was asked for
  std::vector<Point> positions = {};
  std::shared_ptr<const Track> track = {};
  bool else_above = false;  // where the track says nothing, sensors are straight above
};

namespace surface {

// The sensors of the points of one result. Thread-safe once it is made.
class Sensors {
 public:
  // `bounds`: of all points. Errors: usage when attributes that are needed are missing, or when positions are missing
  // or not finite.
  static Result<Sensors> make(const SensorOptions& options, const std::vector<Attribute>& schema, const Bounds& bounds);

  // From now on sensors come from the points' own pulses or scan angles; where these say nothing, sensors are straight
  // above. When the estimate says nothing at all, sensors stay straight above; error usage if only angles were asked
  // for. Also error usage as make(). REQUIRES: an estimate is wanted.
  Status use_estimate(const EstimatedTrack& estimate, const std::vector<Attribute>& schema);
  // Whether nothing better than straight above was found, so that pulses or angles are wanted.
  bool wants_pulses() const { return wants_angles() && !by_angles_; }
  bool wants_angles() const { return how_ == How::vertical && else_above_; }

  struct Sensor {
    Point at;
    bool guessed = false;  // the track does not cover the point's time, so the sensor is taken to be straight above
  };
  // Returns the sensor of a point with this row of attributes; nothing when the row says nothing: not finite, or no
  // direction. Error usage when the sensor is at the point.
  Result<std::optional<Sensor>> of(const Point& point, PointId id, const std::byte* row) const;

  // Returns options that give the same sensors without estimating again.
  SensorOptions found() const;
  // A sentence: what is used, and why.
  const std::string& used() const { return used_; }

 private:
  enum class How : std::uint8_t { vertical, origin, normal, positions, track };
  Status find(const std::vector<Attribute>& schema, bool wanted);
  Status find_times(const std::vector<Attribute>& schema);
  Point read(const std::byte* row) const;

  How how_ = How::vertical;
  std::vector<AttributeColumn> fields_;  // the columns that how_ needs
  std::vector<Point> positions_;
  std::shared_ptr<const Track> track_;
  bool else_above_ = false;  // where nothing better is known, sensors are straight above
  bool by_angles_ = false;   // scan angles alone are asked for, not pulses
  double far_ = 0;           // more than the distance of any two points
  double top_ = 0;
  std::string used_;
};

// How strongly a point votes that what is behind it is inside, up to full_vote. Light that went on after an
// intermediate return did not meet a wall. Uses the attributes return_number and number_of_returns, if there are any.
class Solidity {
 public:
  explicit Solidity(const std::vector<Attribute>& schema);
  std::uint32_t vote(const std::byte* row) const;

 private:
  std::optional<AttributeColumn> number_, count_;
};

}  // namespace surface
}  // namespace tessera

// Where the light came from that made a point.
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
    automatic,  // of the fields, if there are any; else where pulses or scan angles say; else vertical
    vertical,   // from straight above
    fields,     // x_origin, y_origin, z_origin of the point, or the direction nx, ny, nz of its normal
    positions,  // the nearest of some
    track,      // where the scanner was at the point's gps_time
    angles      // where the points' scan angles say; else vertical
  };
  Kind kind = Kind::automatic;
  std::string text = "auto";  // what was asked for
  std::vector<Point> positions = {};
  std::shared_ptr<const Track> track = {};
  bool else_above = false;  // where the track does not say it, sensors are straight above
};

namespace surface {

// Of one result. Constant once made: for several threads at once.
class Sensors {
 public:
  // `bounds`: of all points. Errors: usage when the attributes lack what is wanted, or positions are none or not
  // finite.
  static Result<Sensors> make(const SensorOptions& options, const std::vector<Attribute>& schema, const Bounds& bounds);

  // From then on sensors are where the points' own pulses or scan angles say; straight above where these do not say it.
  // When they say nothing at all, sensors stay straight above, or the error is usage if it is by angles alone that they
  // were to be found. REQUIRES: an estimate is wanted. Error usage as of make(), too.
  Status use_estimate(const EstimatedTrack& estimate, const std::vector<Attribute>& schema);
  // Whether nothing better than straight above was found.
  bool wants_pulses() const { return how_ == How::vertical && automatic_; }
  bool wants_angles() const { return how_ == How::vertical && (automatic_ || by_angles_); }

  struct Sensor {
    Point at;
    bool guessed = false;  // its track does not reach to the point's time: it is taken to be straight above
  };
  // Of a point and the row of its attributes; nothing when the row says nothing: not finite, or no direction.
  // Error usage when the sensor is at the point.
  Result<std::optional<Sensor>> of(const Point& point, PointId id, const std::byte* row) const;

  // Options that give the same sensors, with nothing left to find out.
  SensorOptions found() const;
  // A sentence on what is used, and why.
  const std::string& used() const { return used_; }

 private:
  enum class How : std::uint8_t { vertical, origin, normal, positions, track };
  Status find(const std::vector<Attribute>& schema, bool wanted);
  Status find_times(const std::vector<Attribute>& schema);
  Point read(const std::byte* row) const;

  How how_ = How::vertical;
  std::vector<RowColumn> fields_;  // as how_ wants them
  std::vector<Point> positions_;
  std::shared_ptr<const Track> track_;
  bool automatic_ = false, by_angles_ = false;
  double far_ = 0;  // more than any two points are apart
  double top_ = 0;
  std::string used_;
};

// How much what is behind a point is inside, of full_vote: light that went on after an intermediate return did not meet
// a wall. By the attributes return_number and number_of_returns, where there are any.
class Solidity {
 public:
  explicit Solidity(const std::vector<Attribute>& schema);
  std::uint32_t vote(const std::byte* row) const;

 private:
  std::optional<RowColumn> number_, count_;
};

}  // namespace surface
}  // namespace tessera

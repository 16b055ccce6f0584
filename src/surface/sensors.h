// Where the light came from that made a point.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

struct SensorOptions {
  enum class Kind : std::uint8_t {
    automatic,  // of the fields, if there are any, else vertical
    vertical,   // from straight above
    fields,     // x_origin, y_origin, z_origin of the point, or the direction nx, ny, nz of its normal
    positions   // the nearest of some
  };
  Kind kind = Kind::automatic;
  std::vector<Point> positions = {};
};

namespace surface {

// Of one result. Constant once made: for several threads at once.
class Sensors {
 public:
  // `bounds`: of all points. Errors: usage when the attributes lack what is wanted, or positions are none or not
  // finite.
  static Result<Sensors> make(const SensorOptions& options, const std::vector<Attribute>& schema, const Bounds& bounds);

  // Of a point and the row of its attributes; nothing when the row says nothing: not finite, or no direction.
  // Error usage when the sensor is at the point.
  Result<std::optional<Point>> of(const Point& point, PointId id, const std::byte* row) const;

  // A sentence on what is used, and why.
  const std::string& used() const { return used_; }

 private:
  enum class How : std::uint8_t { vertical, origin, normal, positions };
  struct Field {
    AttributeType type = AttributeType::f64;
    std::size_t offset = 0;
  };
  Status find(const std::vector<Attribute>& schema, bool wanted);
  Point read(const std::byte* row) const;

  How how_ = How::vertical;
  std::vector<Field> fields_;
  std::vector<Point> positions_;
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
  struct Field {
    AttributeType type = AttributeType::u8;
    std::size_t offset = 0;
  };
  std::optional<Field> number_, count_;
};

}  // namespace surface
}  // namespace tessera

// At which angles a scanner looked at points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/attribute_value.h"
#include "src/base/point.h"
#include "src/surface/track/sampled.h"

namespace tessera {

struct AngledPoint {
  std::uint32_t line = 0;  // flight line: point_source_id
  double time = 0;
  double degrees = 0;  // across the flight, from straight below; it does not matter which side is positive
  Point at;
};

// Takes points one by one. Their order does not change the result. Of more than `points_max` points it keeps those of
// some times. Not thread-safe.
class ScanAngles {
 public:
  static constexpr std::size_t points_max = 2'000'000;

  explicit ScanAngles(const std::vector<Attribute>& schema, std::size_t most = points_max);
  // Returns the first attribute that is needed and missing; empty: none is missing.
  const std::string& missing() const { return missing_; }
  // `row`: attributes by the schema. REQUIRES: nothing is missing.
  void add(const Point& at, const std::byte* row);
  void add(const ScanAngles& others) { points_.add(others.points_); }
  // Returns the points by flight line and time; nothing is left.
  std::vector<AngledPoint> take();

 private:
  std::string missing_;
  AttributeColumn angle_, time_;
  std::optional<AttributeColumn> line_;
  Sampled<AngledPoint> points_;
};

}  // namespace tessera

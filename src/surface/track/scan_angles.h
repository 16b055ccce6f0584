// At which angle a scanner looked at points.
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
  double degrees = 0;  // across the flight, from straight below; which side is positive does not matter
  Point at;
};

// Takes points one by one: in any order, with the same outcome. Of more than `points_max` it keeps those of some times.
class ScanAngles {
 public:
  static constexpr std::size_t points_max = 2'000'000;

  explicit ScanAngles(const std::vector<Attribute>& schema, std::size_t most = points_max);
  // The first attribute that is needed and missing; empty: none.
  const std::string& missing() const { return missing_; }
  // `row`: of the schema. REQUIRES: nothing is missing.
  void add(const Point& at, const std::byte* row);
  void add(const ScanAngles& others) { points_.add(others.points_); }
  // By flight line and time; nothing is left.
  std::vector<AngledPoint> take();

 private:
  std::string missing_;
  RowColumn angle_, time_;
  std::optional<RowColumn> line_;
  Sampled<AngledPoint> points_;
};

}  // namespace tessera

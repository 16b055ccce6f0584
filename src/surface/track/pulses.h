// Pulses of which more than one return is known: the scanner was on the line through the returns.
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

struct Pulse {
  std::uint32_t line = 0;  // flight line: point_source_id
  double time = 0;
  Point first, last;  // returns
};

// Takes points one by one and finds the pulses. The order of the points does not change the result. Of more than
// `returns_max` returns it keeps those of some pulses, chosen by their times. Not thread-safe.
class Pulses {
 public:
  static constexpr std::size_t returns_max = 4'000'000;

  explicit Pulses(const std::vector<Attribute>& schema, std::size_t most = returns_max);
  // Returns the first attribute that is needed and missing; empty: none is missing.
  const std::string& missing() const { return missing_; }
  // `row`: attributes by the schema. REQUIRES: nothing is missing.
  void add(const Point& at, const std::byte* row);
  void add(const Pulses& others);
  // Returns the pulses by flight line and time. Ambiguous pulses are left out.
  std::vector<Pulse> take();

 private:
  struct Return {
    std::uint32_t line = 0;
    bool is_first = false;
    double time = 0;
    Point at;
  };

  std::string missing_;
  AttributeColumn number_, count_, time_;
  std::optional<AttributeColumn> line_;
  Sampled<Return> returns_;
};

}  // namespace tessera

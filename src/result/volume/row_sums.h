// Exact sums of the pieces of a row. They do not depend on the order of the pieces.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "src/result/measure/exact_volume.h"
#include "src/result/volume/facet.h"
#include "src/result/volume/overlay.h"

namespace tessera::volume {

// A double as it is, times 2^power. REQUIRES: finite.
inline ScaledInteger scaled(double value, int power = 0) {
  int exponent = 0;
  const double part = std::frexp(value, &exponent);
  constexpr int digits = std::numeric_limits<double>::digits;
  return {static_cast<std::int64_t>(std::ldexp(part, digits)), exponent - digits + power};
}

struct RowSums {
  ExactSum area_a, area_b, covered;  // twice the areas
  ExactSum above, below;
  bool too_large = false;  // a piece was larger than a double can be

  void add_area(ExactSum& to, double area) {
    if (!std::isfinite(area))
      too_large = true;
    else
      to.add(scaled(area, 1));
  }
  void add(const Piece& piece) {
    add_area(covered, piece.area);
    if (!std::isfinite(piece.above) || !std::isfinite(piece.below)) {
      too_large = true;
      return;
    }
    above.add(scaled(piece.above));
    below.add(scaled(piece.below));
  }
  void add(const RowSums& other) {
    area_a.add(other.area_a);
    area_b.add(other.area_b);
    covered.add(other.covered);
    above.add(other.above);
    below.add(other.below);
    too_large = too_large || other.too_large;
  }
};

// Twice the area of a triangle in the plane, exactly.
inline ScaledInteger twice_area(const Facet& facet) { return volume_times_factorial(facet); }

inline ExactSum minus(const ExactSum& a, const ExactSum& b) {
  ExactSum difference = a;
  difference.add(ScaledInteger{-b.value().value, b.value().exponent});
  return difference;
}

}  // namespace tessera::volume

// A made-up landscape as an airborne scanner sees it: hills, flat roofs, trees.
#pragma once

#include <cstdint>

#include "src/base/point.h"
#include "src/base/random.h"

namespace tessera {

// LAS classes.
inline constexpr std::uint8_t class_ground = 2, class_tree = 5, class_building = 6;

// 12 points a square metre on scan lines 29 cm apart, rounded to steps of 1 cm, near Paris in Lambert-93 metres. Where
// a roof stands the beam stops at it; of the other points every fifth is a return from vegetation, in patches.
class Terrain {
 public:
  Terrain(std::uint64_t points, std::uint64_t seed);

  struct Return {
    Point at;
    std::uint8_t classification;
  };
  // Point `index` < points, in flight order. The calls must be made in order: each draws from one stream of numbers.
  Return at(std::uint64_t index);

  Bounds bounds() const;
  static constexpr double step() { return 0.01; }

 private:
  struct Roof {
    bool there;
    double x_lo, x_hi, y_lo, y_hi, height;
  };
  double ground(double x, double y) const;
  Roof roof_near(double x, double y) const;

  Random random_;
  std::uint64_t seed_, columns_, rows_;
  double phase_[6];
};

}  // namespace tessera

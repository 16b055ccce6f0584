// A generated landscape as an airborne scanner sees it: hills, flat roofs, trees.
#pragma once

#include <cstdint>

#include "src/base/point.h"
#include "src/base/random.h"

namespace tessera {

// Classes of LAS.
inline constexpr std::uint8_t class_ground = 2, class_tree = 5, class_building = 6;

// A landscape near Paris, in metres of Lambert-93, with 12 points a square metre. Scan lines are 29 cm apart, and
// coordinates are rounded to steps of 1 cm. A beam that meets a roof stops there. About every fifth of the other points
// is a return from vegetation, in patches.
class Terrain {
 public:
  Terrain(std::uint64_t points, std::uint64_t seed);

  struct Return {
    Point at;
    std::uint8_t classification;
  };
  // Returns point `index`, in the order of the flight. REQUIRES: index < points, and the calls are made in order,
  // because each draws from one stream of random numbers.
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

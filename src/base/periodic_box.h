// Moves points into a periodic box, in such a way that shifts by periods do not round (docs/periodic-design.md).
#pragma once

#include <array>
#include <cmath>

#include "src/base/ieee_arithmetic.h"
#include "src/base/image.h"

namespace tessera {

// Between these bounds no step and no image is too small or too large for a double.
inline constexpr double least_period = 1e-200, greatest_period = 1e200;

// The step of a period: the least power of two of which the period has at most 2^51. REQUIRES: the period lies between
// the bounds.
inline double step_of(double length) {
  int exponent = 0;
  const double fraction = std::frexp(length, &exponent);
  return std::ldexp(1.0, exponent - (fraction == 0.5 ? 52 : 51));
}

// Returns the multiple of the period's step that is nearest to the period. Shifts by that period do not round.
inline double in_steps(double length) { return std::rint(length / step_of(length)) * step_of(length); }

// Whether a number can be a period as it is.
inline bool is_period(double length) {
  return least_period <= length && length <= greatest_period && in_steps(length) == length;
}

// Whether a coordinate of a point in the box is one that shifts do not round.
inline bool is_in_period(double x, double length) {
  const double steps = x / step_of(length);
  return 0 <= x && x < length && steps == std::rint(steps);
}

// The box from 0 to the period. Axes without a period are unbounded.
class PeriodicBox {
 public:
  PeriodicBox() = default;
  // REQUIRES: each period is 0, or in_steps() of itself.
  explicit PeriodicBox(const Period& period) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double length = period.length[axis];
      if (length == 0) continue;
      const double step = step_of(length);
      axes_[axis] = {length, step, 1 / step, length / step};
    }
  }

  struct Moved {
    double to = 0;      // in the box, and a multiple of the step
    double change = 0;  // how far `to` is from the coordinate and its images, exactly
  };
  // REQUIRES: the axis has a period, and x is finite.
  Moved moved(double x, int axis) const {
    const Axis& a = axes_[static_cast<std::size_t>(axis)];
    const double rest = 0 <= x && x < a.length ? x : std::fmod(x, a.length);  // exact
    double steps = std::rint(rest * a.per_step);                              // the only rounding
    const double change = std::abs(rest - steps * a.step);
    if (steps < 0) steps += a.steps;
    if (steps >= a.steps) steps -= a.steps;
    return {steps * a.step + 0.0, change};
  }
  // Whether so many periods lie between a coordinate and the box that the coordinate says little of the place in it.
  bool is_far(double x, int axis) const {
    constexpr double most = 1e12;
    return std::abs(x) / axes_[static_cast<std::size_t>(axis)].length > most;
  }

 private:
  struct Axis {
    double length = 0, step = 0, per_step = 0, steps = 0;
  };
  std::array<Axis, 3> axes_{};
};

}  // namespace tessera

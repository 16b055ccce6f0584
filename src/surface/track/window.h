// Estimates where the scanner was from half a second of a flight line.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/surface/track/pulses.h"
#include "src/surface/track/scan_angles.h"

namespace tessera {

constexpr double degree = 0.017453292519943295;  // in radians
constexpr double window_s = 0.5;
constexpr std::size_t window_observations_min = 50;

struct Window {
  double time = 0;
  Point at;
  double height = 0;            // of the scanner above the points, the median
  std::vector<double> degrees;  // of each observation: between its direction and the direction to `at`
};

struct WindowFit {
  std::size_t observations = 0;  // that can tell something
  std::optional<Window> found;   // nothing: they do not agree on a position
};

// Fit the position at `time`, the middle of the window. REQUIRES: the observations are not empty.
WindowFit fit_window(std::span<const Pulse> pulses, double time);
WindowFit fit_window(std::span<const AngledPoint> points, double time);

// Returns the element that a fraction `part` of the values do not exceed. REQUIRES: values are not empty.
double middle_of(std::vector<double> values, double part = 0.5);
// Whether planes fly at this height.
bool is_height_flown(double height);

}  // namespace tessera

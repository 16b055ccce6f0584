// Half a second of a flight line: where the scanner was, as seen from what it has heard of then.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/surface/track/pulses.h"
#include "src/surface/track/scan_angles.h"

namespace tessera {

constexpr double window_s = 0.5;
constexpr std::size_t window_observations_min = 50;

struct Window {
  double time = 0;
  Point at;
  double height = 0;            // above points, the median
  std::vector<double> degrees;  // of each observation: between its direction and that to the place
};

struct WindowFit {
  std::size_t observations = 0;  // that can tell something
  std::optional<Window> found;   // nothing: they do not agree on a place
};

// REQUIRES: not empty. `time`: of the window's middle, of which the place is wanted.
WindowFit fit_window(std::span<const Pulse> pulses, double time);
WindowFit fit_window(std::span<const AngledPoint> points, double time);

// The element that `part` of them are not above. REQUIRES: values are not empty.
double middle_of(std::vector<double> values, double part = 0.5);
// Whether planes fly so.
bool is_height_flown(double height);

}  // namespace tessera

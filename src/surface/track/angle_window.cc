// Finds the place from which points are seen at their scan angles.
//
// A scanner sweeps across the flight. A point lies at nadir + (height of the scanner above it) * tan(angle) * across,
// where the nadir moves on straight. Least squares of these positions would find too low a scanner: angles are rounded,
// often to whole degrees, and uncertain values must not be regressors. So the fit chooses the height for which angles,
// not positions, agree best. The direction across and the nadir are not affected.
#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/ieee_arithmetic.h"
#include "src/surface/track/time_trend.h"
#include "src/surface/track/window.h"

namespace tessera {

namespace {

constexpr double spread_min = 1;       // degrees: standard deviation of angles, without their trend in time
constexpr double explained_min = 0.7;  // of the variance of positions across, by angles
constexpr double degrees_max = 2;      // the median of a window
constexpr double degrees_fine = 0.05;  // points that agree better weigh no more
constexpr int rounds = 30;

struct Plane {
  double x = 0, y = 0;
};
double dot(Plane a, Plane b) { return a.x * b.x + a.y * b.y; }

// Positions relative to the window's first point; times relative to its middle.
struct Observed {
  std::vector<double> x, y, z, time, tangent;
};

struct Fit {
  double z = 0;  // of the scanner
  Plane nadir, across;
  std::vector<double> degrees;  // how far each point is off
  double spread = 0, explained = 0;
};

// Fits the scanner's position. Points that agree get more weight, round by round. Returns nothing when angles tell
// nothing.
std::optional<Fit> solve(const Observed& of) {
  const std::size_t n = of.x.size();
  std::vector<double> weights(n, 1), across_by_angle(n), rest_x(n), rest_y(n);
  const double ground = middle_of(of.z);
  Fit fit;
  fit.z = ground + 1000;
  fit.degrees.resize(n);
  for (int round = 0; round < rounds; ++round) {
    const TimeTrend by_time(of.time, weights);
    for (std::size_t i = 0; i < n; ++i) across_by_angle[i] = (fit.z - of.z[i]) * of.tangent[i];
    const auto c = by_time.rest(across_by_angle), x = by_time.rest(of.x), y = by_time.rest(of.y);
    const Plane direction{by_time.sum(c, x), by_time.sum(c, y)};
    const double length = std::sqrt(dot(direction, direction)), cc = by_time.sum(c, c);
    if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
    fit.across = {direction.x / length, direction.y / length};
    double ss = 0, sc = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double s = x[i] * fit.across.x + y[i] * fit.across.y;
      ss += weights[i] * s * s;
      sc += weights[i] * s * c[i];
    }
    const double above = ss / sc * (fit.z - ground);
    if (!(above > 0) || !std::isfinite(above)) return std::nullopt;
    fit.spread = std::sqrt(cc / by_time.weight()) / (fit.z - ground) / degree;
    fit.explained = sc * sc / (ss * cc);
    fit.z = ground + above;
    for (std::size_t i = 0; i < n; ++i) {
      const double s = (fit.z - of.z[i]) * of.tangent[i];
      rest_x[i] = of.x[i] - s * fit.across.x;
      rest_y[i] = of.y[i] - s * fit.across.y;
    }
    const auto [at_x, speed_x] = by_time.line(rest_x);
    const auto [at_y, speed_y] = by_time.line(rest_y);
    fit.nadir = {at_x, at_y};
    for (std::size_t i = 0; i < n; ++i) {
      const Plane off{rest_x[i] - at_x - speed_x * of.time[i], rest_y[i] - at_y - speed_y * of.time[i]};
      const double cosine_squared = 1 / (1 + of.tangent[i] * of.tangent[i]);
      fit.degrees[i] = std::atan2(std::sqrt(dot(off, off)) * cosine_squared, above) / degree;
      weights[i] = 1 / std::max(fit.degrees[i], degrees_fine);
    }
  }
  return fit;
}

}  // namespace

WindowFit fit_window(std::span<const AngledPoint> points, double time) {
  WindowFit result{points.size(), std::nullopt};
  if (points.size() < window_observations_min) return result;
  const Point origin = points.front().at;
  Observed of;
  for (const AngledPoint& point : points) {
    of.x.push_back(point.at.x - origin.x);
    of.y.push_back(point.at.y - origin.y);
    of.z.push_back(point.at.z - origin.z);
    of.time.push_back(point.time - time);
    of.tangent.push_back(std::tan(point.degrees * degree));
  }
  auto fit = solve(of);
  if (!fit) return result;
  const double height = fit->z - middle_of(of.z);
  const Point at{fit->nadir.x + origin.x, fit->nadir.y + origin.y, fit->z + origin.z};
  if (fit->spread >= spread_min && fit->explained >= explained_min && is_height_flown(height) &&
      middle_of(fit->degrees) < degrees_max && is_finite(at))
    result.found = Window{time, at, height, std::move(fit->degrees)};
  return result;
}

}  // namespace tessera

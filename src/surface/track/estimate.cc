#include "src/surface/track/estimate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/base/ieee_arithmetic.h"
#include "src/surface/track/time_trend.h"
#include "src/surface/track/window.h"

namespace tessera {

namespace {

constexpr double height_min = 20, height_max = 20'000;
// of the height: how far a window may be off the line's straight path, or off its median height
constexpr double apart_max = 0.1;
constexpr double kept_min = 0.3;  // of a line's windows

// Keeps windows on one straight path, by a robust fit of each coordinate over time.
void drop_strays(std::vector<Window>& windows) {
  std::vector<double> heights;
  for (const Window& window : windows) heights.push_back(window.height);
  if (heights.empty()) return;
  const double height = middle_of(heights);
  std::erase_if(windows, [&](const Window& w) { return std::abs(w.height - height) > apart_max * height; });
  if (windows.size() < 4) return;
  const std::size_t n = windows.size();
  std::vector<double> times, x, y, z, off(n, 1), weights(n);
  for (const Window& window : windows) {
    times.push_back(window.time - windows.front().time);
    x.push_back(window.at.x);
    y.push_back(window.at.y);
    z.push_back(window.at.z);
  }
  for (int round = 0; round < 30; ++round) {
    for (std::size_t i = 0; i < n; ++i) weights[i] = 1 / std::max(off[i], 0.001 * height);
    const TimeTrend by_time(times, weights);
    const auto rest_x = by_time.rest(x), rest_y = by_time.rest(y), rest_z = by_time.rest(z);
    for (std::size_t i = 0; i < n; ++i) {
      off[i] = std::sqrt(rest_x[i] * rest_x[i] + rest_y[i] * rest_y[i] + rest_z[i] * rest_z[i]);
    }
  }
  std::size_t i = 0;
  std::erase_if(windows, [&](const Window&) { return off[i++] > apart_max * height; });
}

// Estimates one flight line. `Observed`: see fit_window().
template <class Observed>
TrackLine estimate_line(std::span<const Observed> observed, TrackLine told, Track& track) {
  std::vector<Window> windows;
  for (std::size_t i = 0, end = 0; i < observed.size(); i = end) {
    const double window = std::floor(observed[i].time / window_s);
    while (end < observed.size() && std::floor(observed[end].time / window_s) == window) ++end;
    auto fit = fit_window(observed.subspan(i, end - i), (window + 0.5) * window_s);
    told.observations += fit.observations;
    if (fit.observations < window_observations_min) continue;
    ++told.windows;
    if (fit.found) windows.push_back(std::move(*fit.found));
  }
  drop_strays(windows);
  told.kept = windows.size();
  if (told.windows == 0) {
    told.refused = told.from == TrackLine::From::pulses ? "too few pulses with several returns"
                                                        : "too few points with scan angles";
  } else if (windows.empty() || static_cast<double>(windows.size()) < kept_min * static_cast<double>(told.windows)) {
    told.refused = told.from == TrackLine::From::pulses
                       ? "its pulses do not come together in one place"
                       : "its scan angles span too little, or do not agree on a place of the scanner";
  }
  if (!told.refused.empty()) return told;
  std::vector<double> degrees, heights;
  std::vector<Track::TrackPoint> places;
  for (const Window& window : windows) {
    degrees.insert(degrees.end(), window.degrees.begin(), window.degrees.end());
    heights.push_back(window.height);
    places.push_back({window.time, window.at});
  }
  told.median_degrees = middle_of(degrees);
  told.most_degrees = middle_of(degrees, 0.99);
  told.height = middle_of(heights);
  track.add(told.line, std::move(places));
  return told;
}

// Returns the observations of a line at the front of `observed`, and removes them from it.
template <class Observed>
std::span<const Observed> take_line(std::span<const Observed>& observed, std::uint32_t line) {
  std::size_t end = 0;
  while (end < observed.size() && observed[end].line == line) ++end;
  const auto taken = observed.first(end);
  observed = observed.subspan(end);
  return taken;
}

}  // namespace

double middle_of(std::vector<double> values, double part) {
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

bool is_height_flown(double height) { return height > height_min && height < height_max; }

EstimatedTrack estimate_track(std::span<const Pulse> pulses, std::span<const AngledPoint> angles) {
  EstimatedTrack estimated;
  while (!pulses.empty() || !angles.empty()) {
    std::uint32_t line = pulses.empty() ? angles.front().line : pulses.front().line;
    if (!angles.empty()) line = std::min(line, angles.front().line);
    const auto with_pulses = take_line(pulses, line);
    const auto with_angles = take_line(angles, line);
    TrackLine told{.line = line, .from = TrackLine::From::pulses, .refused = "no pulses with several returns"};
    if (!with_pulses.empty()) told = estimate_line(with_pulses, {.line = line, .refused = {}}, estimated.track);
    if (!told.refused.empty() && !with_angles.empty()) {
      const TrackLine by_angles =
          estimate_line(with_angles, {.line = line, .from = TrackLine::From::angles, .refused = {}}, estimated.track);
      if (by_angles.refused.empty() || with_pulses.empty()) told = by_angles;
    }
    estimated.lines.push_back(std::move(told));
  }
  return estimated;
}

}  // namespace tessera

// Finds the place to which the lines of pulses come nearest.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "src/base/ieee_arithmetic.h"
#include "src/surface/track/window.h"

namespace tessera {

namespace {

constexpr double length_min = 3;         // from the first return to the last, in units of the coordinates
constexpr double pulse_degrees_max = 2;  // the median of a window
constexpr double uncertain_max = 0.15;   // of the height: its standard deviation
constexpr std::size_t pairs = 300;
constexpr int pulse_rounds = 10;

Point minus(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double norm(const Point& a) { return std::sqrt(dot(a, a)); }

// The line of a pulse, relative to the window's first pulse.
struct Line {
  Point from, way;  // the first return; upwards, of length 1
  double length = 0;
};

// A weighted sum of squared distances to lines, as a quadratic form.
struct Squares {
  std::array<std::array<double, 3>, 3> m{};
  std::array<double, 3> b{};

  void add(const Line& line, double weight) {
    for (int i = 0; i < 3; ++i) {
      double sum = 0;
      for (int j = 0; j < 3; ++j) {
        const double part = weight * ((i == j ? 1.0 : 0.0) - line.way[i] * line.way[j]);
        m[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] += part;
        sum += part * line.from[j];
      }
      b[static_cast<std::size_t>(i)] += sum;
    }
  }

  // Returns where the sum is least, and the entry for z of the inverse matrix, to which the variance of the height is
  // proportional.
  std::optional<std::pair<Point, double>> least() const {
    const auto cofactor = [&](std::size_t i, std::size_t j) {
      const std::size_t a = (i + 1) % 3, c = (i + 2) % 3, d = (j + 1) % 3, e = (j + 2) % 3;
      return m[a][d] * m[c][e] - m[a][e] * m[c][d];
    };
    const double det = m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
    const double trace = m[0][0] + m[1][1] + m[2][2];
    if (!(det > 1e-12 * trace * trace * trace)) return std::nullopt;
    Point at;
    for (int i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) at[i] += cofactor(j, static_cast<std::size_t>(i)) / det * b[j];
    return std::pair(at, cofactor(2, 2) / det);
  }
};

double degrees_between(const Line& line, const Point& at) {
  const Point to = minus(at, line.from);
  const double length = norm(to);
  if (!(length > 0)) return 180;
  const Point off{to.y * line.way.z - to.z * line.way.y, to.z * line.way.x - to.x * line.way.z,
                  to.x * line.way.y - to.y * line.way.x};
  return std::atan2(norm(off), dot(to, line.way)) / degree;
}

// Returns where two lines come nearest to each other; nothing when they are almost parallel.
std::optional<Point> between(const Line& a, const Line& b) {
  const double c = dot(a.way, b.way), apart = 1 - c * c;
  if (apart < 1e-4) return std::nullopt;
  const Point from = minus(b.from, a.from);
  const double s = (dot(from, a.way) - c * dot(from, b.way)) / apart,
               t = (c * dot(from, a.way) - dot(from, b.way)) / apart;
  return Point{(a.from.x + s * a.way.x + b.from.x + t * b.way.x) / 2,
               (a.from.y + s * a.way.y + b.from.y + t * b.way.y) / 2,
               (a.from.z + s * a.way.z + b.from.z + t * b.way.z) / 2};
}

// Pairs of pulses meet at places; returns the place with which most pulses agree. Wrong pulses pull a mean towards the
// ground, but here they only do not agree.
std::optional<Point> start(const std::vector<Line>& lines) {
  std::optional<Point> best;
  std::size_t most = 0;
  const std::size_t n = lines.size(), stride = std::max<std::size_t>(n / 200, 1);
  for (std::size_t k = 0; k < pairs; ++k) {
    const std::size_t i = k * 7919 % n, j = (i + 1 + k * 104'729 % (n - 1)) % n;
    const auto at = between(lines[i], lines[j]);
    if (!at || !is_finite(*at)) continue;
    std::size_t agree = 0;
    for (std::size_t l = 0; l < n; l += stride) agree += degrees_between(lines[l], *at) < pulse_degrees_max ? 1 : 0;
    if (agree <= most) continue;
    most = agree;
    best = at;
  }
  return best;
}

// Least squares of the pulses that agree, beginning at that place.
std::optional<Window> solve(const std::vector<Line>& lines, double time) {
  const auto begin = start(lines);
  if (!begin) return std::nullopt;
  Point at = *begin;
  std::vector<double> degrees;
  for (const Line& line : lines) degrees.push_back(degrees_between(line, at));
  double variance = 0;
  const auto fit = [&](const auto& weight) {
    Squares squares;
    for (std::size_t i = 0; i < lines.size(); ++i) squares.add(lines[i], weight(i));
    const auto least = squares.least();
    if (!least || !is_finite(least->first)) return false;
    at = least->first;
    variance = least->second;
    for (std::size_t i = 0; i < lines.size(); ++i) degrees[i] = degrees_between(lines[i], at);
    return true;
  };
  const auto square = [&](std::size_t i) { return lines[i].length * lines[i].length; };
  std::size_t agree = 0;
  double sum = 0;
  for (int round = 0; round < pulse_rounds; ++round) {
    const double most = std::max(3 * middle_of(degrees), 0.2);
    const std::vector<double> before = degrees;
    if (!fit([&](std::size_t i) { return before[i] <= most ? square(i) : 0; })) return std::nullopt;
    agree = 0;
    sum = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (before[i] > most) continue;
      ++agree;
      const double off = std::sin(std::min(degrees[i], 90.0) * degree) * norm(minus(at, lines[i].from));
      sum += square(i) * off * off;
    }
  }
  std::vector<double> heights;
  for (const Line& line : lines) heights.push_back(at.z - line.from.z);
  Window window{time, at, middle_of(heights), degrees};
  const double deviation = std::sqrt(variance * sum / static_cast<double>(std::max<std::size_t>(agree, 4) - 3));
  const bool good = agree >= window_observations_min && 2 * agree >= lines.size() && is_height_flown(window.height) &&
                    deviation < uncertain_max * window.height && middle_of(degrees) < pulse_degrees_max;
  return good ? std::optional(std::move(window)) : std::nullopt;
}

}  // namespace

WindowFit fit_window(std::span<const Pulse> pulses, double time) {
  const Point origin = pulses.front().first;
  std::vector<Line> lines;
  for (const Pulse& pulse : pulses) {
    const Point way = minus(pulse.first, pulse.last);
    const double length = norm(way);
    if (!(length >= length_min) || !(way.z > 0) || !std::isfinite(length)) continue;
    lines.push_back({minus(pulse.first, origin), {way.x / length, way.y / length, way.z / length}, length});
  }
  WindowFit fit{lines.size(), std::nullopt};
  if (lines.size() < window_observations_min) return fit;
  fit.found = solve(lines, time);
  if (fit.found) fit.found->at = {fit.found->at.x + origin.x, fit.found->at.y + origin.y, fit.found->at.z + origin.z};
  return fit;
}

}  // namespace tessera

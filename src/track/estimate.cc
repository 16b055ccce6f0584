#include "src/track/estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "src/base/ieee_arithmetic.h"

namespace tessera {

namespace {

constexpr double window_s = 0.5;
constexpr double length_min = 3;  // from the first return to the last, in units of the coordinates
constexpr std::size_t pulses_min = 50;
constexpr double degrees_max = 2;  // the median of a window
constexpr double height_min = 20, height_max = 20'000;
constexpr double uncertain_max = 0.15;  // of the height: its standard deviation
constexpr double apart_max = 0.1;       // of the height: from the line's straight way, or its median height
constexpr double kept_min = 0.3;        // of a line's windows
constexpr std::size_t pairs = 300;
constexpr int rounds = 10;
constexpr double degree = 0.017453292519943295;

Point minus(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
double norm(const Point& a) { return std::sqrt(dot(a, a)); }

double middle_of(std::vector<double> values, double part = 0.5) {
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

// Of a pulse, around the window's first one.
struct Line {
  Point from, way;  // the first return; up, of length 1
  double length = 0;
};

// Weighted squares of distances to lines, as a quadratic form.
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

  // Where they are least; and the inverse's entry for z, to which the height's variance is in proportion.
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

struct Window {
  double time = 0;
  Point at;
  double height = 0;
  std::vector<double> degrees;
};

// Where two lines come nearest to each other; nothing when they are all but parallel.
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

// Of the places where some pairs of pulses meet, the one with which most of the others agree: wrong pulses, which pull
// sums of any kind to the ground, only do not agree.
std::optional<Point> start(const std::vector<Line>& lines) {
  std::optional<Point> best;
  std::size_t most = 0;
  const std::size_t n = lines.size(), stride = std::max<std::size_t>(n / 200, 1);
  for (std::size_t k = 0; k < pairs; ++k) {
    const std::size_t i = k * 7919 % n, j = (i + 1 + k * 104'729 % (n - 1)) % n;
    const auto at = between(lines[i], lines[j]);
    if (!at || !is_finite(*at)) continue;
    std::size_t agree = 0;
    for (std::size_t l = 0; l < n; l += stride) agree += degrees_between(lines[l], *at) < degrees_max ? 1 : 0;
    if (agree <= most) continue;
    most = agree;
    best = at;
  }
  return best;
}

// Least squares of the pulses that agree, from that start on.
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
  for (int round = 0; round < rounds; ++round) {
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
  const bool good = agree >= pulses_min && 2 * agree >= lines.size() && window.height > height_min &&
                    window.height < height_max && deviation < uncertain_max * window.height &&
                    middle_of(degrees) < degrees_max;
  return good ? std::optional(std::move(window)) : std::nullopt;
}

// Those on one straight way, by a fit like the above of each coordinate by time.
void drop_strays(std::vector<Window>& windows) {
  std::vector<double> heights;
  for (const Window& window : windows) heights.push_back(window.height);
  if (heights.empty()) return;
  const double height = middle_of(heights);
  std::erase_if(windows, [&](const Window& w) { return std::abs(w.height - height) > apart_max * height; });
  if (windows.size() < 4) return;
  const double begin = windows.front().time;
  std::vector<double> off(windows.size(), 1);
  for (int round = 0; round < 30; ++round) {
    double w = 0, t = 0, tt = 0;
    Point p, tp;
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const double weight = 1 / std::max(off[i], 0.001 * height), time = windows[i].time - begin;
      w += weight;
      t += weight * time;
      tt += weight * time * time;
      for (int k = 0; k < 3; ++k) {
        p[k] += weight * windows[i].at[k];
        tp[k] += weight * time * windows[i].at[k];
      }
    }
    const double det = w * tt - t * t;
    if (!(det > 0)) return;
    for (std::size_t i = 0; i < windows.size(); ++i) {
      Point away;
      for (int k = 0; k < 3; ++k) {
        const double speed = (w * tp[k] - t * p[k]) / det, place = (p[k] - speed * t) / w;
        away[k] = windows[i].at[k] - place - speed * (windows[i].time - begin);
      }
      off[i] = norm(away);
    }
  }
  std::size_t i = 0;
  std::erase_if(windows, [&](const Window&) { return off[i++] > apart_max * height; });
}

// Of one flight line.
TrackLine estimate_line(std::span<const Pulse> pulses, Track& track) {
  TrackLine told{.line = pulses.front().line, .refused = {}};
  std::vector<Window> windows;
  std::vector<Line> lines;
  for (std::size_t i = 0; i < pulses.size();) {
    const double window = std::floor(pulses[i].time / window_s);
    const Point origin = pulses[i].first;
    lines.clear();
    for (; i < pulses.size() && std::floor(pulses[i].time / window_s) == window; ++i) {
      const Point way = minus(pulses[i].first, pulses[i].last);
      const double length = norm(way);
      if (!(length >= length_min) || !(way.z > 0) || !std::isfinite(length)) continue;
      lines.push_back({minus(pulses[i].first, origin), {way.x / length, way.y / length, way.z / length}, length});
    }
    told.pulses += lines.size();
    if (lines.size() < pulses_min) continue;
    ++told.windows;
    auto found = solve(lines, (window + 0.5) * window_s);
    if (!found) continue;
    found->at = {found->at.x + origin.x, found->at.y + origin.y, found->at.z + origin.z};
    windows.push_back(std::move(*found));
  }
  drop_strays(windows);
  told.kept = windows.size();
  if (told.windows == 0) {
    told.refused = "too few pulses with several returns";
  } else if (windows.empty() || static_cast<double>(windows.size()) < kept_min * static_cast<double>(told.windows)) {
    told.refused = "its pulses do not come together in one place";
  }
  if (!told.refused.empty()) return told;
  std::vector<double> degrees, heights;
  std::vector<Track::Place> places;
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

}  // namespace

EstimatedTrack estimate_track(const std::vector<Pulse>& pulses) {
  EstimatedTrack estimated;
  for (std::size_t i = 0, end = 0; i < pulses.size(); i = end) {
    while (end < pulses.size() && pulses[end].line == pulses[i].line) ++end;
    estimated.lines.push_back(estimate_line(std::span(pulses).subspan(i, end - i), estimated.track));
  }
  return estimated;
}

}  // namespace tessera

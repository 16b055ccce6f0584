#include "src/service/questions/map_features.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/base/json/json_text.h"

namespace tessera::service {
namespace {

// Clipping by Liang and Barsky.
bool leg_meets(const Point& a, const Point& b, const Bounds& box) {
  double begin = 0, end = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double step = b[axis] - a[axis];
    if (step == 0) {
      if (a[axis] < box.lo[axis] || a[axis] > box.hi[axis]) return false;
      continue;
    }
    double enter = (box.lo[axis] - a[axis]) / step, leave = (box.hi[axis] - a[axis]) / step;
    if (enter > leave) std::swap(enter, leave);
    begin = std::max(begin, enter);
    end = std::min(end, leave);
  }
  return begin <= end;
}

// Nine decimals of a degree are a tenth of a millimetre.
void add_degrees(std::string& to, double degrees) {
  char digits[64];
  std::string text(digits, std::to_chars(digits, digits + sizeof digits, degrees, std::chars_format::fixed, 9).ptr);
  while (text.ends_with('0')) text.pop_back();
  if (text.ends_with('.')) text.pop_back();
  to += text == "-0" ? "0" : text;
}

void add_shortest(std::string& to, double number) {
  char digits[32];
  to.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

}  // namespace

bool line_meets(std::span<const Point> line, const Bounds& box) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    if (leg_meets(line[i], line[i + 1], box)) return true;
  return false;
}

bool ring_meets(std::span<const Point> ring, const Bounds& box) {
  if (line_meets(ring, box)) return true;
  // The ring does not meet the sides of the box, so the box is wholly inside or wholly outside.
  bool inside = false;
  for (std::size_t i = 0; i + 1 < ring.size(); ++i) {
    const Point &a = ring[i], &b = ring[i + 1];
    if ((a.y > box.lo.y) != (b.y > box.lo.y) && box.lo.x < (b.x - a.x) * (box.lo.y - a.y) / (b.y - a.y) + a.x)
      inside = !inside;
  }
  return inside;
}

std::vector<Point> dense_ring(std::span<const Point> corners) {
  constexpr int steps = 8;
  std::vector<Point> ring;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point &a = corners[i], &b = corners[(i + 1) % corners.size()];
    // A hull with many corners is dense enough.
    const int parts = corners.size() > 64 ? 1 : steps;
    for (int k = 0; k < parts; ++k) {
      const double part = static_cast<double>(k) / parts;
      ring.push_back({std::lerp(a.x, b.x, part), std::lerp(a.y, b.y, part), 0});
    }
  }
  if (!ring.empty()) ring.push_back(ring.front());
  return ring;
}

Result<bool> FeaturePage::add(std::uint64_t id, const nlohmann::ordered_json& properties, Kind kind,
                              std::vector<Point> points, std::optional<double> third) {
  const bool is_ring = kind == Kind::ring && points.size() > 3;
  const auto met = [&] { return !box_ || (is_ring ? ring_meets(points, *box_) : line_meets(points, *box_)); };
  if (form_.stored_box && !met()) return true;
  if (!form_.stored || (box_ && !form_.stored_box)) {
    std::vector<Point> own;
    if (form_.stored) own = points;
    BOOST_OUTCOME_TRYV(places_.to(points));
    if (!form_.stored_box && !met()) return true;
    if (form_.stored) points.swap(own);
  }
  if (count_ >= limit_ || (count_ > 0 && points_ + points.size() > points_max)) {
    full_ = true;
    return false;
  }
  ++count_;
  last_ = id;
  points_ += points.size();
  text_ += text_.empty() ? "" : ",";
  text_ += "{\"type\":\"Feature\",\"id\":" + std::to_string(id) + ",\"properties\":" + json_text(properties) +
           ",\"geometry\":";
  text_ += is_ring ? "{\"type\":\"Polygon\",\"coordinates\":[[" : "{\"type\":\"LineString\",\"coordinates\":[";
  for (std::size_t i = 0; i < points.size(); ++i) {
    text_ += i == 0 ? "[" : ",[";
    const bool swapped = form_.stored && form_.swapped;
    const auto add = form_.stored ? add_shortest : add_degrees;
    add(text_, swapped ? points[i].y : points[i].x);
    text_ += ',';
    add(text_, swapped ? points[i].x : points[i].y);
    if (third) {
      text_ += ',';
      add_shortest(text_, *third);
    }
    text_ += ']';
  }
  text_ += is_ring ? "]]}}" : "]}}";
  return true;
}

}  // namespace tessera::service

#include "src/result/voronoi/cell_shape.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/voronoi/corner_order.h"

namespace tessera::voronoi {

namespace {

// Whether a ring is convex and runs counterclockwise once. Corners may lie on the line between their neighbours.
bool is_convex(const Ring& ring) {
  const std::size_t n = ring.size();
  if (n < 3) return false;
  std::size_t turns = 0, straight = 0;
  bool up = before(ring[n - 1], ring[0]);
  for (std::size_t i = 0; i < n; ++i) {
    const Point &a = ring[i], &b = ring[i + 1 < n ? i + 1 : 0], &c = ring[i + 2 < n ? i + 2 : i + 2 - n];
    const int sign = exact::orientation_2(a, b, c);
    if (sign < 0) return false;
    straight += sign == 0 ? 1 : 0;
    turns += before(a, b) != up ? 1 : 0;
    up = before(a, b);
  }
  return turns == 2 && straight < n;
}

bool on(const Point& p, const RingSide& side) {
  return std::min(side.a.x, side.b.x) <= p.x && p.x <= std::max(side.a.x, side.b.x) &&
         std::min(side.a.y, side.b.y) <= p.y && p.y <= std::max(side.a.y, side.b.y);
}

// Whether two sides meet where sides of a valid part do not. Sides of one ring share only the corner between
// successors; sides of two rings may touch in a point.
bool clash(const RingSide& e, const RingSide& f) {
  const int fa = exact::orientation_2(e.a, e.b, f.a), fb = exact::orientation_2(e.a, e.b, f.b);
  const int ea = exact::orientation_2(f.a, f.b, e.a), eb = exact::orientation_2(f.a, f.b, e.b);
  if (fa * fb < 0 && ea * eb < 0) return true;
  const bool e_first = e.ring == f.ring && (e.number + 1) % e.sides == f.number;
  const bool f_first = e.ring == f.ring && (f.number + 1) % e.sides == e.number;
  if (fa == 0 && fb == 0) {  // on one line: an overlap is a clash
    const auto [e_low, e_high] = std::minmax(e.a, e.b, before);
    const auto [f_low, f_high] = std::minmax(f.a, f.b, before);
    const Point low = std::max(e_low, f_low, before), high = std::min(e_high, f_high, before);
    if (before(low, high)) return true;
    return same(low, high) && e.ring == f.ring && !e_first && !f_first;
  }
  const bool touch =
      (fa == 0 && on(f.a, e)) || (fb == 0 && on(f.b, e)) || (ea == 0 && on(e.a, f)) || (eb == 0 && on(e.b, f));
  return touch && e.ring == f.ring && !e_first && !f_first;
}

}  // namespace

ShapeMeasures measure(const CellShape& shape) {
  const Point& origin = shape.parts.front().front().front();
  long double twice = 0, x = 0, y = 0;
  for (const auto& part : shape.parts) {
    for (const Ring& ring : part) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
        const long double ax = static_cast<long double>(a.x) - origin.x, ay = static_cast<long double>(a.y) - origin.y;
        const long double bx = static_cast<long double>(b.x) - origin.x, by = static_cast<long double>(b.y) - origin.y;
        const long double turn = ax * by - ay * bx;
        twice += turn;
        x += turn * (ax + bx);
        y += turn * (ay + by);
      }
    }
  }
  const auto place = [&](long double moment, double from) { return static_cast<double>(from + moment / (3 * twice)); };
  return {static_cast<double>(twice / 2), {place(x, origin.x), place(y, origin.y), 0}};
}

bool part_before(const std::vector<Ring>& a, const std::vector<Ring>& b) {
  return before(a.front().front(), b.front().front());
}

void remove_repeated(Ring& ring) {
  ring.erase(std::unique(ring.begin(), ring.end(), same), ring.end());
  while (ring.size() > 1 && same(ring.front(), ring.back())) ring.pop_back();
}

void begin_with_least(Ring& ring) {
  std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end(), before), ring.end());
}

bool runs_counterclockwise(const Ring& ring) {
  const std::size_t n = ring.size();
  const auto least = static_cast<std::size_t>(std::min_element(ring.begin(), ring.end(), before) - ring.begin());
  return exact::orientation_2(ring[(least + n - 1) % n], ring[least], ring[(least + 1) % n]) > 0;
}

std::optional<std::pair<RingSide, RingSide>> find_clash(std::span<const Ring> part) {
  std::vector<RingSide> sides;
  for (std::uint32_t r = 0; r < part.size(); ++r) {
    const Ring& ring = part[r];
    const auto n = static_cast<std::uint32_t>(ring.size());
    for (std::uint32_t i = 0; i < n; ++i) sides.push_back({ring[i], ring[(i + 1) % n], r, i, n});
  }
  const auto low = [](const RingSide& side) { return std::min(side.a.x, side.b.x); };
  std::stable_sort(sides.begin(), sides.end(), [&](const RingSide& a, const RingSide& b) { return low(a) < low(b); });
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const double end = std::max(sides[i].a.x, sides[i].b.x);
    for (std::size_t j = i + 1; j < sides.size() && low(sides[j]) <= end; ++j)
      if (clash(sides[i], sides[j])) return std::pair(sides[i], sides[j]);
  }
  return std::nullopt;
}

bool is_valid(std::span<const Ring> part) {
  if (part.size() == 1 && is_convex(part[0])) return true;
  for (std::size_t r = 0; r < part.size(); ++r)
    if (part[r].size() < 3 || runs_counterclockwise(part[r]) != (r == 0)) return false;
  return !find_clash(part);
}

namespace {

// Little endian, with the numbers of types of the OGC.
class WkbWriter {
 public:
  void begin(std::uint32_t type, std::size_t count) {
    put(std::uint8_t{1});
    put(type);
    put(static_cast<std::uint32_t>(count));
  }
  void corner(const Point& p) {
    put(p.x);
    put(p.y);
  }
  template <class Value>
  void put(const Value& value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

template <class Value>
Value take_value(const std::byte*& at) {
  Value value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

constexpr std::uint32_t polygon_type = 3, multipolygon_type = 6;

}  // namespace

std::vector<std::byte> to_wkb(const CellShape& shape, bool multi) {
  WkbWriter wkb;
  if (multi) {
    wkb.begin(multipolygon_type, shape.parts.size());
  } else if (shape.parts.empty()) {
    wkb.begin(polygon_type, 0);
  }
  for (const auto& part : shape.parts) {
    wkb.begin(polygon_type, part.size());
    for (const Ring& ring : part) {
      wkb.put(static_cast<std::uint32_t>(ring.size() + 1));
      for (const Point& p : ring) wkb.corner(p);
      wkb.corner(ring.front());
    }
  }
  return wkb.take();
}

CellShape shape_of_wkb(std::span<const std::byte> wkb) {
  CellShape shape;
  const std::byte* at = wkb.data() + 1;
  const bool multi = take_value<std::uint32_t>(at) == multipolygon_type;
  const std::uint32_t parts = multi ? take_value<std::uint32_t>(at) : 1;
  for (std::uint32_t p = 0; p < parts; ++p) {
    if (multi) at += 1 + sizeof(std::uint32_t);
    std::vector<Ring> part(take_value<std::uint32_t>(at));
    for (Ring& ring : part) {
      ring.resize(take_value<std::uint32_t>(at));
      for (Point& corner : ring) {
        corner.x = take_value<double>(at);
        corner.y = take_value<double>(at);
      }
      ring.pop_back();
    }
    if (!part.empty()) shape.parts.push_back(std::move(part));
  }
  return shape;
}

}  // namespace tessera::voronoi

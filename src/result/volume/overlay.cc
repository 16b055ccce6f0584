#include "src/result/volume/overlay.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstddef>
#include <utility>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/volume/estimate.h"

namespace tessera::volume {
namespace {

using Exact = boost::multiprecision::cpp_rational;

// The most that the error of a value may be, divided by the value, before fractions are used.
constexpr long double tolerance = 0x1p-43L;

// Returns the next corner, or the next edge, of a triangle.
constexpr std::size_t next(std::size_t k) { return k == 2 ? 0 : k + 1; }

template <class Number>
struct Vector {
  Number x, y;
  friend Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y}; }
  friend Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y}; }
};
template <class Number>
Number cross(const Vector<Number>& a, const Vector<Number>& b) {
  return Number(a.x * b.y) - Number(a.y * b.x);
}
template <class Number>
Vector<Number> between(const Point& from, const Point& to) {
  return {Number(to.x) - Number(from.x), Number(to.y) - Number(from.y)};
}

// The line through an edge of a triangle. The triangle is on its left.
struct Line {
  std::size_t facet = 0, edge = 0;
};

// The common part of triangles: a convex polygon, as the lines that bound it, counterclockwise. Corner k is where line
// k ends and line k + 1 begins.
class Common {
 public:
  static constexpr std::size_t facets_max = 3, lines_max = 3 * facets_max;

  explicit Common(const Facet& first) : facets_{&first}, count_(3) {
    for (std::size_t k = 0; k < 3; ++k) lines_[k] = {0, k};
  }

  // Returns false if the polygon and the triangle have no interior in common.
  bool clip(const Facet& facet) {
    facets_[known_++] = &facet;
    for (std::size_t k = 0; k < 3; ++k)
      if (!clip(Line{known_ - 1, k})) return false;
    return true;
  }

  std::size_t size() const { return count_; }
  const Line& line(std::size_t k) const { return lines_[k % count_]; }
  const Facet& facet(std::size_t number) const { return *facets_[number]; }
  const Point& from(const Line& line) const { return (*facets_[line.facet])[line.edge]; }
  const Point& to(const Line& line) const { return (*facets_[line.facet])[next(line.edge)]; }

 private:
  bool clip(const Line& line) {
    std::array<int, lines_max> side{};  // of the corner after each line
    bool inside = false, outside = false;
    for (std::size_t k = 0; k < count_; ++k) {
      side[k] = side_of(line, lines_[k], lines_[(k + 1) % count_]);
      inside = inside || side[k] > 0;
      outside = outside || side[k] < 0;
    }
    if (!inside) return false;
    if (!outside) return true;
    std::array<Line, lines_max> kept;
    std::size_t count = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      const int begin = side[(k + count_ - 1) % count_], end = side[k];
      if (begin > 0 || end > 0) kept[count++] = lines_[k];
      if (begin > 0 && end <= 0) kept[count++] = line;
    }
    lines_ = kept;
    count_ = count;
    return true;
  }

  // On which side of `line` the corner between the lines `in` and `out` is: 1 on the left, 0 on the line. This is the
  // sign of the determinant of three lines, because `out` turns left from `in`. When two of the lines belong to one
  // triangle, they meet in a vertex, and the determinant has the sign of an orientation of points.
  int side_of(const Line& line, const Line& in, const Line& out) const {
    if (in.facet == out.facet) return orientation(line, from(out));
    if (line.facet == in.facet)
      return in.edge == next(line.edge) ? orientation(out, from(in)) : -orientation(out, from(line));
    if (line.facet == out.facet)
      return line.edge == next(out.edge) ? orientation(in, from(line)) : -orientation(in, from(out));
    if (const int sign = determinant<Estimate>(in, out, line).sign(); sign != 0) return sign;
    const Exact exact = determinant<Exact>(in, out, line);
    return exact.sign();
  }
  int orientation(const Line& line, const Point& p) const {
    const auto flat = [](const Point& q) { return Point{q.x, q.y, 0}; };
    return exact::orientation_2(flat(from(line)), flat(to(line)), flat(p));
  }
  template <class Number>
  Number determinant(const Line& a, const Line& b, const Line& c) const {
    const Point& origin = (*facets_[0])[0];
    struct Row {
      Vector<Number> along;
      Number moment;
    };
    const auto row = [&](const Line& line) {
      const Vector<Number> along = between<Number>(from(line), to(line));
      return Row{along, cross(along, between<Number>(from(line), origin))};
    };
    const Row i = row(a), j = row(b), k = row(c);
    return Number(i.moment * cross(j.along, k.along)) + Number(j.moment * cross(k.along, i.along)) +
           Number(k.moment * cross(i.along, j.along));
  }

  std::array<const Facet*, facets_max> facets_{};
  std::size_t known_ = 1;
  std::array<Line, lines_max> lines_;
  std::size_t count_;
};

// A corner of the common part: its place relative to the first vertex of the first triangle, and the height of A over
// B.
template <class Number>
struct Corner {
  Vector<Number> at;
  Number height;
};

// Computes the corners of a common part.
template <class Number>
class Corners {
 public:
  // `lower` is the number of the triangle of B; 0: B is level.
  Corners(const Common& common, std::size_t lower, double level)
      : common_(common), origin_(common.facet(0)[0]), lower_(lower), level_(level) {}

  Corner<Number> corner(std::size_t k) const {
    const Line &in = common_.line(k), &out = common_.line(k + 1);
    if (in.facet == out.facet) {
      const Point& vertex = common_.from(out);
      const Place place{.at = between<Number>(origin_, vertex), .vertex = &vertex, .in = in, .out = out};
      return {place.at, height(place)};
    }
    // The line `in` reaches the corner after the fraction `from_in` of its edge, and likewise `out`.
    const Vector<Number> a = between<Number>(common_.from(in), common_.to(in)),
                         b = between<Number>(common_.from(out), common_.to(out)),
                         apart = between<Number>(common_.from(in), common_.from(out));
    const Number turn = cross(a, b);
    Place place{.vertex = nullptr, .in = in, .out = out};
    place.along_in = Number(cross(apart, b) / turn);
    place.along_out = Number(cross(apart, a) / turn);
    const bool first = in.facet < out.facet;
    const Vector<Number>& way = first ? a : b;
    const Number& part = first ? place.along_in : place.along_out;
    place.at = between<Number>(origin_, common_.from(first ? in : out)) +
               Vector<Number>{Number(way.x * part), Number(way.y * part)};
    return {place.at, height(place)};
  }

 private:
  struct Place {
    Vector<Number> at = {};
    const Point* vertex = nullptr;  // that it is, if it is one
    Line in = {}, out = {};
    Number along_in = {}, along_out = {};
  };

  // The height of a surface as the sum of a height in the input and a difference.
  struct Height {
    double of_vertex = 0;
    Number more;
  };

  Number height(const Place& place) const {
    const Height a = height_on(0, place);
    const Height b = lower_ == 0 ? Height{level_, Number(0.0)} : height_on(lower_, place);
    return Number(Number(Number(a.of_vertex) - Number(b.of_vertex)) + Number(a.more - b.more));
  }

  Height height_on(std::size_t number, const Place& place) const {
    const Facet& facet = common_.facet(number);
    if (place.vertex != nullptr)
      for (const Point& p : facet)
        if (p.x == place.vertex->x && p.y == place.vertex->y) return {p.z, Number(0.0)};
    if (place.vertex == nullptr && (place.in.facet == number || place.out.facet == number)) {
      const bool on_in = place.in.facet == number;
      const Line& line = on_in ? place.in : place.out;
      const Number rise = Number(common_.to(line).z) - Number(common_.from(line).z);
      return {common_.from(line).z, Number((on_in ? place.along_in : place.along_out) * rise)};
    }
    const Vector<Number> a = between<Number>(facet[0], facet[1]), b = between<Number>(facet[0], facet[2]),
                         p = place.at + between<Number>(facet[0], origin_);
    const Number twice = cross(a, b);
    const Number rise_a = Number(facet[1].z) - Number(facet[0].z), rise_b = Number(facet[2].z) - Number(facet[0].z);
    return {facet[0].z,
            Number(Number(Number(cross(p, b) / twice) * rise_a) + Number(Number(cross(a, p) / twice) * rise_b))};
  }

  const Common& common_;
  const Point& origin_;
  std::size_t lower_;
  double level_;
};

// The mean of max(value, 0) over a triangle on which the value is linear, with the values of its corners. All terms are
// positive, so that nothing is lost by cancellation.
template <class Number>
Number mean_above(Number a, Number b, Number c) {
  if (a < b) std::swap(a, b);
  if (b < c) std::swap(b, c);
  if (a < b) std::swap(a, b);
  if (a <= 0) return Number(0);
  if (c >= 0) return Number((a + b + c) / 3);
  if (b <= 0) return Number(a / 3 * Number(a / Number(a - b)) * Number(a / Number(a - c)));
  // Above is a quadrilateral: two triangles, with the values a, b, 0 and 0, b, 0 or likewise.
  const Number along_a = a / Number(a - c), along_b = b / Number(b - c), rest = Number(-c) / Number(a - c);
  return Number(Number(along_a * Number(a + b) + Number(rest * along_b) * b) / 3);
}

template <class Number>
struct Sums {
  Number area = 0, above = 0, below = 0;
  void add(const Number& part, const Number& a, const Number& b, const Number& c) {
    area += part;
    above += part * mean_above<Number>(a, b, c);
    below += part * mean_above<Number>(Number(-a), Number(-b), Number(-c));
  }
};

// Returns nothing if rounding may have spoilt the values.
std::optional<Piece> estimated(const Common& common, std::size_t lower, double level) {
  const Corners<Estimate> corners(common, lower, level);
  std::array<Corner<Estimate>, Common::lines_max> at;
  for (std::size_t k = 0; k < common.size(); ++k) at[k] = corners.corner(k);
  Sums<long double> sums;
  long double area_error = 0, volume_error = 0;
  for (std::size_t k = 1; k + 1 < common.size(); ++k) {
    const Estimate twice = cross(at[k].at - at[0].at, at[k + 1].at - at[0].at);
    const long double area = std::fmax(twice.value, 0.0L) / 2, off = twice.error / 2;
    long double most = 0, doubt = 0;
    for (const auto* corner : {&at[0], &at[k], &at[k + 1]}) {
      most = std::fmax(most, std::fabs(corner->height.value));
      doubt = std::fmax(doubt, corner->height.error);
      if (!(corner->height.error < 1e4000L)) return std::nullopt;
    }
    // The mean changes by no more than the values do.
    sums.add(area, at[0].height.value, at[k].height.value, at[k + 1].height.value);
    area_error += off;
    volume_error += off * (most + doubt) + area * doubt;
  }
  volume_error += 64 * Estimate::unit * (sums.above + sums.below);
  area_error += 64 * Estimate::unit * sums.area;
  if (!(1.01L * area_error <= tolerance * sums.area)) return std::nullopt;
  if (!(1.01L * volume_error <= tolerance * (sums.above + sums.below))) return std::nullopt;
  return Piece{static_cast<double>(sums.area), static_cast<double>(sums.above), static_cast<double>(sums.below)};
}

Piece exactly(const Common& common, std::size_t lower, double level) {
  const Corners<Exact> corners(common, lower, level);
  const Corner<Exact> first = corners.corner(0);
  Corner<Exact> last = corners.corner(1);
  Sums<Exact> sums;
  for (std::size_t k = 2; k < common.size(); ++k) {
    const Corner<Exact> here = corners.corner(k);
    const Exact area = cross(last.at - first.at, here.at - first.at) / 2;
    sums.add(area, first.height, last.height, here.height);
    last = here;
  }
  return {static_cast<double>(sums.area), static_cast<double>(sums.above), static_cast<double>(sums.below)};
}

// The same triangle with heights 0.
Facet flat(const Facet& facet) {
  Facet level = facet;
  for (Point& p : level) p.z = 0;
  return level;
}

bool is_flat(const Facet& facet) { return facet[0].z == 0 && facet[1].z == 0 && facet[2].z == 0; }

bool in_one_plane(const Facet& a, const Facet& b) {
  return std::all_of(a.begin(), a.end(),
                     [&](const Point& p) { return exact::orientation_3(b[0], b[1], b[2], p) == 0; });
}

}  // namespace

std::optional<Piece> overlay(const Sides& sides) {
  Common common(*sides.upper);
  if (sides.lower != nullptr && !common.clip(*sides.lower)) return std::nullopt;
  if (sides.within != nullptr && !common.clip(*sides.within)) return std::nullopt;
  const std::size_t lower = sides.lower == nullptr ? 0 : 1;
  if (const auto piece = estimated(common, lower, sides.level)) return piece;
  // Fractions would take a thousand times as long to find that two triangles are in one plane.
  if (sides.lower != nullptr && in_one_plane(*sides.upper, *sides.lower) && !is_flat(*sides.upper)) {
    const Facet upper = flat(*sides.upper), level = flat(*sides.lower);
    return overlay({.upper = &upper, .lower = &level, .within = sides.within});
  }
  return exactly(common, lower, sides.level);
}

double common_area(const Facet& a, const Facet& b) {
  const Facet level = flat(a);
  const auto piece = overlay({.upper = &level, .within = &b});
  return piece ? piece->area : 0;
}

}  // namespace tessera::volume

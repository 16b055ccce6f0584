// The value at a point q between the vertices of a 2D triangulation, by the natural neighbours of q.
//
// The zone of q is the set of cells whose open circumcircle contains q, found with exact predicates. It is a polygon
// without vertices inside, and q sees all of its border. The corners of the border are the natural neighbours of q: the
// vertices that would share an edge with q if q were a vertex.
//   natural: the weight of a neighbour is the area that the Voronoi cell of q would take from that of the neighbour
//            (Sibson, A vector identity for the Dirichlet tessellation, 1980).
//   laplace: the weight is the length of the Voronoi edge between q and the neighbour, divided by their distance
//            (Belikov et al., The non-Sibsonian interpolation, 1997; Sugihara, Surface interpolation based on new local
//            coordinates, 1999).
// Both are continuous, and give the value of a vertex at the vertex and a linear function everywhere. Cocircular
// vertices may be triangulated in any way: their cells have one circle, so they are in the zone together.
//
// The sums. Positions are relative to q. A border edge from a to b, counterclockwise, has the circumcentre G of (q, a,
// b). G = a/2 + s turned(a) = b/2 - t turned(b), where s and t are half the cotangents of the triangle's angles at b
// and a. The Laplace weight of a neighbour is s of the edge that begins there plus t of the edge that ends there. The
// area that q takes from a neighbour is a polygon of two G and of the centres of the zone's cells around the neighbour.
// So twice the sum of areas times values is
//   sum over border edges of (s |a|^2 value(a) + t |b|^2 value(b)) / 2
//   + sum over all edges of the zone, border and inside, of (value(a) - value(b)) (X x C),
// where C is the centre of the cell on the left of (a, b), and X that of the cell on the right; for border edges X = G.
// Values are taken relative to that of a corner, so that large heights lose no digits.
//
// Each number carries a bound of its rounding error (as in src/geometry/predicates/exact). When the bound of a sum is
// too large, the sum is computed again with 64 and then 512 bits. The order of all sums begins at the corner of the
// first cell that has the least source index. So the bits depend on q and the triangulation alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "src/base/point.h"
#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/query/dual.h"
#include "src/result/terrain/dem_method.h"

namespace tessera::terrain {

// What is beyond an edge of a cell. failed: the reason is with the cells.
enum class Beyond : std::uint8_t { cell, hull, unknown, failed };

// How the sum for a point ended. on_hull: the point is on an edge of the hull. unknown: the zone goes on in cells that
// are not known. no_value: the value of a neighbour is not finite. unsure: rounding has spoilt the sum.
enum class PixelState : std::uint8_t { found, on_hull, unknown, no_value, unsure, failed };

// A centre as far as it is known; `error` bounds |dx| + |dy|.
template <class Number>
struct Centre {
  Number x = 0, y = 0, error = 0;
};

// The circumcentre of a cell relative to the first of its corners, which is the one with the least source index. So the
// bits are the same in all tiles.
struct CellCircle {
  Centre<double> centre;
  std::uint8_t first = 0;
};

template <class Number>
struct Rounding {
  // Half of the distance from 1 to the next number.
  static Number unit() {
    if constexpr (std::is_same_v<Number, double>)
      return 0x1p-53;
    else if constexpr (std::is_same_v<Number, query::Long>)
      return std::numeric_limits<query::Long>::epsilon() / 2;
    else
      return std::numeric_limits<query::Wide>::epsilon();
  }
  // Products of this size and more are not spoilt by underflow of their factors.
  static Number least() {
    if constexpr (std::is_same_v<Number, double>)
      return 1e-150;
    else if constexpr (std::is_same_v<Number, query::Long>)
      return std::numeric_limits<query::Long>::min() * 0x1p8000L;
    else
      return 0;
  }
  static Number size(const Number& x) { return x < 0 ? Number(-x) : x; }
};
template <>
inline double Rounding<double>::size(const double& x) {
  return std::abs(x);
}

// The circumcentre of the counterclockwise (p, q, r), relative to p. The error is infinite when rounding may have
// spoilt it.
template <class Number>
Centre<Number> centre_of(const Point& p, const Point& q, const Point& r) {
  using R = Rounding<Number>;
  const Number bx = Number(q.x) - Number(p.x), by = Number(q.y) - Number(p.y);
  const Number cx = Number(r.x) - Number(p.x), cy = Number(r.y) - Number(p.y);
  const Number left = bx * cy, right = by * cx, area = left - right, sizes = R::size(left) + R::size(right);
  const Number bb = bx * bx + by * by, cc = cx * cx + cy * cy, half = Number(0.5) / area;
  const Number reach = (bb * (R::size(cx) + R::size(cy)) + cc * (R::size(bx) + R::size(by))) * half;
  Centre<Number> centre{(bb * cy - cc * by) * half, (cc * bx - bb * cx) * half, 0};
  // The sums in the numerators are off by 6 u, the area by 4 u of `sizes`; the rest is reserve.
  centre.error = R::unit() * reach * (16 + 8 * sizes * (2 * half));
  const bool sure = area > 64 * R::unit() * sizes && area > R::least() && centre.error - centre.error == 0;
  if (!sure) centre = {0, 0, std::numeric_limits<Number>::infinity()};
  return centre;
}

// Whether q is inside the circle of the cell. `corner(k)` is its corner.
template <class Corner>
bool is_in_circle(const CellCircle& circle, const Point& q, const Corner& corner) {
  const Centre<double>& c = circle.centre;
  const Point& p = corner(circle.first);
  const double dx = q.x - p.x, dy = q.y - p.y, mx = std::abs(dx), my = std::abs(dy);
  // |q - centre|^2 - |p - centre|^2
  const double power = dx * (dx - 2 * c.x) + dy * (dy - 2 * c.y);
  const double sizes = mx * (mx + 2 * std::abs(c.x)) + my * (my + 2 * std::abs(c.y));
  const double error = 2 * (mx + my) * c.error + 8 * 0x1p-53 * sizes + 1e-290;
  if (power < -error) return true;
  if (power > error) return false;
  return exact::in_circle_2(corner(0), corner(1), corner(2), q) > 0;
}

// Computes values at points. `Cells` has
//   a type Cell, a cell of the triangulation;
//   point(cell, k) and value(cell, k), of corner k; corners are counterclockwise;
//   circle(cell), its CellCircle;
//   across(cell, k, to), what is beyond the edge opposite corner k: if it is a cell, `to` becomes that cell;
//   opposite(cell, k, to, back): `back` becomes the corner of `to` opposite the same edge; false if there is none, then
//   the cells are damaged;
//   cells_max(), a number that no zone exceeds; too_many(), called when one does, because the cells are damaged.
template <class Number, class Cells>
class NaturalValue {
 public:
  using Cell = typename Cells::Cell;
  NaturalValue(Cells& cells, DemMethod method) : cells_(cells), natural_(method == DemMethod::natural) {}

  // REQUIRES: q is in the closed cell, and not one of its corners.
  PixelState at(const Cell& cell, const Point& q, double& value) {
    q_ = q;
    sum_ = {};
    near_.clear();
    if (!start(cell)) return PixelState::no_value;
    while (open_count_ > 0) {
      const Edge edge = open_[--open_count_];
      const PixelState state = pass(edge);
      if (state != PixelState::found) return state;
    }
    // The bounds have a reserve for sums of this many terms.
    constexpr double terms = 16;
    const Number error = (sum_.error + R::unit() * sum_.rounding) * (1 + Number(near_.size()) / terms);
    if (!(error <= tolerance * sum_.weight) || !(sum_.weight > R::least())) return PixelState::unsure;
    const Number found = base_ + sum_.value / sum_.weight;
    if (!(found - found == 0)) return PixelState::unsure;
    value = static_cast<double>(found);
    return PixelState::found;
  }

 private:
  using R = Rounding<Number>;
  // Values are right to twice this part of the range of the neighbours' values, or better.
  static constexpr double tolerance = 0x1p-37;

  // A neighbour, relative to q and to the base of the values.
  struct Neighbour {
    Point at;
    Number x, y, value;
    Number size;  // |x| + |y|
  };
  struct ZoneCentre {
    Centre<Number> at;  // relative to q
    Number size = 0;    // |x| + |y|
  };
  // The edge opposite a corner of a zone cell, from neighbour a to neighbour b.
  struct Edge {
    Cell cell;
    std::uint32_t a, b;
    std::uint8_t corner;
    ZoneCentre centre;  // of the cell
  };
  struct Sum {
    Number value = 0, weight = 0;
    Number error = 0, rounding = 0;  // the bound is error + unit() * rounding
  };

  static std::uint8_t next(std::size_t k) { return static_cast<std::uint8_t>(k == 2 ? 0 : k + 1); }
  static std::uint8_t before(std::size_t k) { return static_cast<std::uint8_t>(k == 0 ? 2 : k - 1); }
  static Number sum_of_sizes(const Number& x, const Number& y) { return R::size(x) + R::size(y); }

  ZoneCentre centre_at(const Cell& cell, const CellCircle& circle) const {
    const std::size_t first = circle.first;
    const Point& p = cells_.point(cell, first);
    Centre<Number> c;
    if constexpr (std::is_same_v<Number, double>)
      c = circle.centre;
    else
      c = centre_of<Number>(p, cells_.point(cell, next(first)), cells_.point(cell, before(first)));
    const Number dx = Number(p.x) - Number(q_.x), dy = Number(p.y) - Number(q_.y);
    const Number x = dx + c.x, y = dy + c.y;
    return {{x, y, c.error + 4 * R::unit() * (sum_of_sizes(dx, dy) + sum_of_sizes(c.x, c.y))}, sum_of_sizes(x, y)};
  }

  // Returns false when the value is not finite.
  bool add_neighbour(const Cell& cell, std::size_t k) {
    const double value = cells_.value(cell, k);
    const Point& p = cells_.point(cell, k);
    const Number x = Number(p.x) - Number(q_.x), y = Number(p.y) - Number(q_.y);
    near_.push_back({p, x, y, Number(value) - base_, sum_of_sizes(x, y)});
    return std::isfinite(value);
  }

  Edge& open() {
    if (open_count_ == open_.size()) open_.resize(2 * open_.size());
    return open_[open_count_++];
  }

  // So that the border is passed counterclockwise.
  bool start(const Cell& cell) {
    const CellCircle circle = cells_.circle(cell);
    const std::uint8_t first = circle.first;
    base_ = Number(cells_.value(cell, first));
    ZoneCentre centre;
    if (natural_) centre = centre_at(cell, circle);
    bool finite = true;
    for (const std::uint8_t k : {first, next(first), before(first)}) finite = add_neighbour(cell, k) && finite;
    open_count_ = 0;
    open() = {cell, 2, 0, next(first), centre};
    open() = {cell, 1, 2, first, centre};
    open() = {cell, 0, 1, before(first), centre};
    return finite;
  }

  PixelState pass(const Edge& edge) {
    Cell beyond;
    switch (cells_.across(edge.cell, edge.corner, beyond)) {
      case Beyond::hull:
        return add_border(edge);
      case Beyond::unknown:
        return PixelState::unknown;
      case Beyond::failed:
        return PixelState::failed;
      case Beyond::cell:
        break;
    }
    const CellCircle& circle = cells_.circle(beyond);
    if (!is_in_circle(circle, q_, [&](std::size_t k) -> const Point& { return cells_.point(beyond, k); }))
      return add_border(edge);
    std::size_t back = 0;
    if (!cells_.opposite(edge.cell, edge.corner, beyond, back)) return PixelState::failed;
    const auto apex = static_cast<std::uint32_t>(near_.size());
    if (apex > cells_.cells_max() + 2) {
      cells_.too_many(beyond);
      return PixelState::failed;
    }
    if (!add_neighbour(beyond, back)) return PixelState::no_value;
    ZoneCentre centre;
    if (natural_) {
      centre = centre_at(beyond, circle);
      add_edge(edge, centre);
    }
    open() = {beyond, apex, edge.b, before(back), centre};
    open() = {beyond, edge.a, apex, next(back), centre};
    return PixelState::found;
  }

  // `right` is the centre on the other side of the edge.
  void add_edge(const Edge& edge, const ZoneCentre& right) {
    const ZoneCentre& left = edge.centre;
    const Number step = near_[edge.a].value - near_[edge.b].value;
    sum_.value += step * (right.at.x * left.at.y - right.at.y * left.at.x);
    sum_.error += right.size * left.at.error + (left.size + left.at.error) * right.at.error;
    sum_.rounding += 6 * left.size * right.size;
  }

  PixelState add_border(const Edge& edge) {
    const Neighbour &a = near_[edge.a], &b = near_[edge.b];
    const Number ex = Number(b.at.x) - Number(a.at.x), ey = Number(b.at.y) - Number(a.at.y);
    const Number l = a.x * b.y, r = a.y * b.x, area = l - r, sizes = R::size(l) + R::size(r);
    if (!(area > 64 * R::unit() * sizes && area > R::least()))
      return exact::orientation_2(a.at, b.at, q_) <= 0 ? PixelState::on_hull : PixelState::unsure;
    const Number half = Number(0.5) / area;
    const Number s = (b.x * ex + b.y * ey) * half, t = -(a.x * ex + a.y * ey) * half;
    // A product of two differences is off by 3 u, their sum by 4 u; the area by 4 u of `sizes`. So s is off by u times
    // `off` times the size of b, and t likewise by that of a.
    const Number off = (32 + 16 * sizes * half) * half * sum_of_sizes(ex, ey);
    if (!natural_) {
      sum_.weight += s + t;
      sum_.value += s * a.value + t * b.value;
      sum_.rounding += off * (a.size + b.size);
      return PixelState::found;
    }
    const Number sa = (a.x * a.x + a.y * a.y) * s / 2, tb = (b.x * b.x + b.y * b.y) * t / 2;
    const Number both = off * a.size * b.size;
    sum_.weight += sa + tb;
    sum_.value += sa * a.value + tb * b.value;
    sum_.rounding += both * (a.size + b.size);
    const Number gx = a.x / 2 - s * a.y, gy = a.y / 2 + s * a.x;
    add_edge(edge, {{gx, gy, R::unit() * (2 * both + 4 * a.size)}, sum_of_sizes(gx, gy)});
    return PixelState::found;
  }

  Cells& cells_;
  bool natural_;
  Point q_{};
  Number base_ = 0;
  Sum sum_;
  std::vector<Neighbour> near_;
  std::vector<Edge> open_ = std::vector<Edge>(64);
  std::size_t open_count_ = 0;
};

// The value at q with as many bits as the value needs. `fast` is kept from point to point. REQUIRES: as at().
template <class Cells>
PixelState natural_value(Cells& cells, NaturalValue<double, Cells>& fast, DemMethod method,
                         const typename Cells::Cell& cell, const Point& q, double& value) {
  PixelState state = fast.at(cell, q, value);
  if (state == PixelState::unsure) state = NaturalValue<query::Long, Cells>(cells, method).at(cell, q, value);
  if (state == PixelState::unsure) state = NaturalValue<query::Wide, Cells>(cells, method).at(cell, q, value);
  return state;
}

}  // namespace tessera::terrain

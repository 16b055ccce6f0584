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
  static constexpr bool is_wide = std::is_same_v<Number, query::Wide>;
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
//   across(cell, k, to, back), what is beyond the edge opposite corner k: if it is a cell, `to` becomes that cell and
//   `back` the corner of it that is opposite the same edge.
template <class Number, class Cells>
class NaturalValue {
 public:
  using Cell = typename Cells::Cell;
  NaturalValue(Cells& cells, DemMethod method) : cells_(cells), natural_(method == DemMethod::natural) {}

  // REQUIRES: q is in the closed cell, and not one of its corners.
  PixelState at(const Cell& cell, const Point& q, double& value) {
    q_ = q;
    sum_ = {};
    open_.clear();
    start(cell);
    while (!open_.empty()) {
      const Edge edge = open_.back();
      open_.pop_back();
      const PixelState state = pass(edge);
      if (state != PixelState::found) return state;
    }
    // The bounds have a reserve for sums of this many terms.
    constexpr double terms = 16;
    const Number error = sum_.error * (1 + Number(sum_.terms) / terms);
    if (sum_.spoilt || !(error <= tolerance * sum_.weight) || !(sum_.weight > R::least())) return PixelState::unsure;
    const Number found = base_ + sum_.value / sum_.weight;
    if (!(found - found == 0)) return PixelState::unsure;
    value = static_cast<double>(found);
    return PixelState::found;
  }

 private:
  using R = Rounding<Number>;
  // Values are right to twice this part of the range of the neighbours' values, or better.
  static constexpr double tolerance = 0x1p-37;

  // The edge opposite a corner of a zone cell.
  struct Edge {
    Cell cell;
    std::uint8_t corner;
    Centre<Number> centre;  // of the cell
  };
  struct Sum {
    Number value = 0, weight = 0, error = 0;
    std::uint32_t terms = 0;
    bool spoilt = false;
  };

  static std::uint8_t next(std::size_t k) { return static_cast<std::uint8_t>(k == 2 ? 0 : k + 1); }
  static std::uint8_t before(std::size_t k) { return static_cast<std::uint8_t>(k == 0 ? 2 : k - 1); }

  Centre<Number> centre_at(const Cell& cell, const CellCircle& circle) const {
    const std::size_t first = circle.first;
    const Point& p = cells_.point(cell, first);
    Centre<Number> c;
    if constexpr (std::is_same_v<Number, double>)
      c = circle.centre;
    else
      c = centre_of<Number>(p, cells_.point(cell, next(first)), cells_.point(cell, before(first)));
    const Number dx = Number(p.x) - Number(q_.x), dy = Number(p.y) - Number(q_.y);
    const Number sizes = R::size(dx) + R::size(dy) + R::size(c.x) + R::size(c.y);
    return {dx + c.x, dy + c.y, c.error + 4 * R::unit() * sizes};
  }

  // So that the border is passed counterclockwise.
  void start(const Cell& cell) {
    const CellCircle circle = cells_.circle(cell);
    base_ = Number(cells_.value(cell, circle.first));
    Centre<Number> centre;
    if (natural_) centre = centre_at(cell, circle);
    const std::uint8_t first = circle.first;
    open_.push_back({cell, next(first), centre});
    open_.push_back({cell, first, centre});
    open_.push_back({cell, before(first), centre});
  }

  PixelState pass(const Edge& edge) {
    Cell beyond;
    std::size_t back = 0;
    switch (cells_.across(edge.cell, edge.corner, beyond, back)) {
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
    Centre<Number> centre;
    if (natural_) {
      centre = centre_at(beyond, circle);
      add_edge(edge, centre);
    }
    open_.push_back({beyond, before(back), centre});
    open_.push_back({beyond, next(back), centre});
    return PixelState::found;
  }

  // `right` is the centre on the other side of the edge.
  void add_edge(const Edge& edge, const Centre<Number>& right) {
    const Centre<Number>& left = edge.centre;
    const Number step =
        Number(cells_.value(edge.cell, next(edge.corner))) - Number(cells_.value(edge.cell, before(edge.corner)));
    sum_.value += step * (right.x * left.y - right.y * left.x);
    const Number nl = R::size(left.x) + R::size(left.y), nr = R::size(right.x) + R::size(right.y);
    sum_.error += nr * left.error + nl * right.error + left.error * right.error + 6 * R::unit() * nl * nr;
    ++sum_.terms;
  }

  PixelState add_border(const Edge& edge) {
    const Point& pa = cells_.point(edge.cell, next(edge.corner));
    const Point& pb = cells_.point(edge.cell, before(edge.corner));
    const Number ax = Number(pa.x) - Number(q_.x), ay = Number(pa.y) - Number(q_.y);
    const Number bx = Number(pb.x) - Number(q_.x), by = Number(pb.y) - Number(q_.y);
    const Number ex = Number(pb.x) - Number(pa.x), ey = Number(pb.y) - Number(pa.y);
    const Number l = ax * by, r = ay * bx, area = l - r, sizes = R::size(l) + R::size(r);
    if (!(area > 64 * R::unit() * sizes && area > R::least())) {
      if (exact::orientation_2(pa, pb, q_) <= 0) return PixelState::on_hull;
      if (!(area > 0)) return PixelState::unsure;
      sum_.spoilt = true;
    }
    const Number half = Number(0.5) / area;
    const Number s = (bx * ex + by * ey) * half, t = -(ax * ex + ay * ey) * half;
    const Number na = R::size(ax) + R::size(ay), nb = R::size(bx) + R::size(by), ne = R::size(ex) + R::size(ey);
    // A product of two differences is off by 3 u, their sum by 4 u; the area by 4 u of `sizes`.
    const Number off = R::unit() * (32 + 8 * sizes * (2 * half)) * half * ne;
    const Number s_error = off * nb, t_error = off * na;
    const double va = cells_.value(edge.cell, next(edge.corner)), vb = cells_.value(edge.cell, before(edge.corner));
    if (!std::isfinite(va) || !std::isfinite(vb)) return PixelState::no_value;
    const Number a = Number(va) - base_, b = Number(vb) - base_;
    sum_.terms += 2;
    if (!natural_) {
      sum_.weight += s + t;
      sum_.value += s * a + t * b;
      sum_.error += s_error + t_error;
      return PixelState::found;
    }
    const Number sa = (ax * ax + ay * ay) * s / 2, tb = (bx * bx + by * by) * t / 2;
    sum_.weight += sa + tb;
    sum_.value += sa * a + tb * b;
    sum_.error += (na * na * s_error + nb * nb * t_error) / 2;
    add_edge(edge, {ax / 2 - s * ay, ay / 2 + s * ax, na * (s_error + 4 * R::unit() * (1 + R::size(s)))});
    return PixelState::found;
  }

  Cells& cells_;
  bool natural_;
  Point q_{};
  Number base_ = 0;
  Sum sum_;
  std::vector<Edge> open_;
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

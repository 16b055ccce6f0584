// The part of a vertex's Voronoi cell that one Delaunay cell around the vertex contributes.
//
// The part is a sum of signed simplices from the vertex over the middle of an edge and, in 3D, the circumcentre of a
// facet, to the circumcentre of the cell (the orthoscheme or flag decomposition). The sum of all parts around a vertex
// that is not on the hull is its Voronoi cell, also where single parts are negative: there the circumcentre lies
// outside of the Delaunay cell.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "src/result/query/dual.h"

namespace tessera {

template <class Number>
struct VoronoiPart {
  Number volume = 0;               // in 2D area
  Number surface = 0;              // in 2D length of the boundary
  query::Vec<Number> moment = {};  // the integral of the place relative to the vertex
  long double doubt = 0;           // a bound of the sum of the absolute values that rounding errors are relative to

  void add(const VoronoiPart& other) {
    volume += other.volume;
    surface += other.surface;
    moment = moment + other.moment;
    doubt += other.doubt;
  }
};

namespace voronoi {

template <class Number>
Number length_of(const query::Vec<Number>& a) {
  using std::sqrt;
  return sqrt(query::dot(a, a));
}

// Adds a signed simplex with the vertex as one corner; `mean` is the mean of all its corners. Its height over the face
// of the Voronoi cell is half of `edge`.
template <class Number>
void add_flag(VoronoiPart<Number>& part, const Number& signed_volume, const query::Vec<Number>& mean,
              const Number& edge, int dimension) {
  part.volume += signed_volume;
  part.moment = part.moment + signed_volume * mean;
  part.surface += 2 * dimension * signed_volume / edge;
}

template <class Number>
VoronoiPart<Number> part_2(const query::Vec<Number>& a, const query::Vec<Number>& b) {
  using query::Vec;
  const Number twice = a.x * b.y - a.y * b.x, aa = query::dot(a, a), bb = query::dot(b, b);
  const Vec<Number> centre{(aa * b.y - bb * a.y) / (2 * twice), (bb * a.x - aa * b.x) / (2 * twice), 0};
  const Number half = Number(1) / 2, third = Number(1) / 3, la = length_of(a), lb = length_of(b);
  VoronoiPart<Number> part;
  add_flag<Number>(part, (a.x * centre.y - a.y * centre.x) / 4, third * (half * a + centre), la, 2);
  add_flag<Number>(part, (centre.x * b.y - centre.y * b.x) / 4, third * (half * b + centre), lb, 2);
  const auto reach = static_cast<long double>(la * lb * (la + lb) / (2 * twice));  // at least the circumradius
  const auto turn = 1 + static_cast<long double>(la * lb / twice);
  part.doubt = static_cast<long double>(la + lb) * reach * turn / 4;
  return part;
}

// The Voronoi cell of a vertex in 2D as one sum. `corners` are its neighbours relative to it, counterclockwise, from a
// first one that does not depend on how they are stored; each and the next are in one Delaunay cell. The same sum as
// that of part_2(), with one root and two divisions for each neighbour.
template <class Number>
VoronoiPart<Number> cell_2(std::span<const query::Vec<Number>> corners) {
  using query::Vec;
  VoronoiPart<Number> cell;
  const Vec<Number>& first = corners.front();
  const Number first_square = query::dot(first, first), first_length = length_of(first);
  Number aa = first_square, la = first_length, first_flag = 0, flag_before = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const bool last = k + 1 == corners.size();
    const Vec<Number>&a = corners[k], &b = last ? first : corners[k + 1];
    const Number bb = last ? first_square : query::dot(b, b), lb = last ? first_length : length_of(b);
    const Number twice = a.x * b.y - a.y * b.x, half = 1 / (2 * twice);
    const Number x = (aa * b.y - bb * a.y) * half, y = (bb * a.x - aa * b.x) * half;  // of the circumcentre
    const Number at_a = a.x * y - a.y * x, at_b = x * b.y - y * b.x;                  // areas times 4
    cell.volume += at_a + at_b;
    const Number both = at_a + at_b;
    cell.moment.x += (at_a * a.x + at_b * b.x) / 2 + both * x;
    cell.moment.y += (at_a * a.y + at_b * b.y) / 2 + both * y;
    // The edge of the Voronoi cell between it and that of a neighbour has two triangles, of which one is in each cell.
    if (k == 0)
      first_flag = at_a;
    else
      cell.surface += (flag_before + at_a) / la;
    flag_before = at_b;
    const Number sizes = la * lb, reach = sizes * (la + lb) * half;
    cell.doubt += static_cast<long double>((la + lb) * reach * (1 + 2 * sizes * half));
    aa = bb;
    la = lb;
  }
  cell.surface += (flag_before + first_flag) / first_length;
  cell.doubt /= 4;
  cell.volume /= 4;
  cell.moment = (Number(1) / 12) * cell.moment;
  return cell;
}

template <class Number>
VoronoiPart<Number> part_3(const query::Vec<Number>& a, const query::Vec<Number>& b, const query::Vec<Number>& c) {
  using query::Vec;
  const Vec<Number> bc = query::cross(b, c), ca = query::cross(c, a), ab = query::cross(a, b);
  const Number six = query::dot(a, bc);
  const Number aa = query::dot(a, a), bb = query::dot(b, b), cc = query::dot(c, c);
  const Vec<Number> centre = (1 / (2 * six)) * (aa * bc + bb * ca + cc * ab);
  const auto reach =
      static_cast<long double>((aa * length_of(bc) + bb * length_of(ca) + cc * length_of(ab)) / (2 * six)) *
      (1 + static_cast<long double>(length_of(a) * length_of(bc) / six));
  const Number half = Number(1) / 2, quarter = Number(1) / 4;
  VoronoiPart<Number> part;
  const auto facet = [&](const Vec<Number>& p, const Vec<Number>& q, const Number& pp, const Number& qq,
                         const Vec<Number>& normal) {
    const Number nn = query::dot(normal, normal), lp = length_of(p), lq = length_of(q);
    const Vec<Number> middle = (1 / (2 * nn)) * query::cross(pp * q - qq * p, normal);
    const Vec<Number> turn = query::cross(middle, centre);
    add_flag<Number>(part, query::dot(p, turn) / 12, quarter * (half * p + middle + centre), lp, 3);
    add_flag<Number>(part, -query::dot(q, turn) / 12, quarter * (half * q + middle + centre), lq, 3);
    const auto flat = static_cast<long double>(lp * lq / length_of(normal));
    part.doubt += static_cast<long double>(lp + lq) * static_cast<long double>(lp + lq) * flat * flat * reach / 12;
  };
  facet(a, b, aa, bb, ab);
  facet(b, c, bb, cc, bc);
  facet(c, a, cc, aa, ca);
  return part;
}

}  // namespace voronoi

// `others` are the other d corners of the Delaunay cell, relative to the vertex, in such an order that the vertex and
// they are positively oriented.
template <class Number>
VoronoiPart<Number> voronoi_part(std::span<const query::Vec<Number>> others) {
  return others.size() == 2 ? voronoi::part_2(others[0], others[1]) : voronoi::part_3(others[0], others[1], others[2]);
}

}  // namespace tessera

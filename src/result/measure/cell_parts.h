// What a Delaunay cell in space contributes to the Voronoi cells of its vertices.
//
// A part is a sum of signed tetrahedra: from the vertex over the middle of an edge and the circumcentre of a facet to
// the circumcentre P of the cell (the orthoscheme or flag decomposition). The sum of all parts of a vertex that is not
// on the hull is its Voronoi cell, also where single parts are negative: there a circumcentre lies outside of the facet
// or the cell. The tetrahedra at both ends of an edge mirror each other, so they have the same volume: for the edge vw
// of the facet uvw with the normal N = (v - u) x (w - u), towards the cell, it is
//   height of P * |vw|^2 cot(u) / 24 = (P - u).N / N.N * |vw|^2 (v - u).(w - u) / 24.
//
// The errors. Let e be the share by which operations are rounded, R the circumradius of the cell and r that of a facet,
// and F the flatness: the product of the three edges of a vertex, divided by six times the volume of the cell. The
// volume has an error of some 8 e F times itself, P one of 44 e F R, and so has the height. The other factor, |vw|^2
// cot(u) = 2 r^2 sin(2u), is at most 2 r^2, with an error of some e F r^2. So the volume of such a tetrahedron has an
// error of 5 e F R r^2 at most, with e the half of an epsilon. VoronoiPart::doubt has 4 F R r^2 epsilons for each.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "src/base/point.h"
#include "src/result/measure/voronoi_part.h"
#include "src/result/query/dual.h"

namespace tessera::voronoi {

template <class Number>
class CellParts {
  using Vec = query::Vec<Number>;
  using Long = query::Long;

 public:
  // REQUIRES: the corners are positively oriented.
  explicit CellParts(const std::array<Point, 4>& corners) {
    static constexpr std::size_t ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    for (std::size_t e = 0; e < 6; ++e) {
      edge_[e] = query::relative<Number>(corners[ends[e][1]], corners[ends[e][0]]);
      square_[e] = query::dot(edge_[e], edge_[e]);
      length_[e] = root(square_[e]);
    }
    const Vec ab = query::cross(edge_[e01], edge_[e02]), bc = query::cross(edge_[e02], edge_[e03]),
              ca = query::cross(edge_[e03], edge_[e01]);
    const Number six = query::dot(edge_[e01], bc);
    centre_ = (1 / (2 * six)) * (square_[e01] * bc + square_[e02] * ca + square_[e03] * ab);
    const auto length = [&](Edge e) { return long_of(length_[e]); };
    flatness_ = length(e01) * (length(e02) * length(e03) + length(e12) * length(e13)) / long_of(six);
    add_facet({0, 1, 2}, {e01, e02, e12}, edge_[e01], edge_[e02], edge_[e12], ab, centre_);
    add_facet({0, 2, 3}, {e02, e03, e23}, edge_[e02], edge_[e03], edge_[e23], bc, centre_);
    add_facet({0, 3, 1}, {e03, e01, e13}, edge_[e03], edge_[e01], minus(edge_[e13]), ca, centre_);
    add_facet({1, 3, 2}, {e13, e12, e23}, edge_[e13], edge_[e12], minus(edge_[e23]),
              query::cross(edge_[e13], edge_[e12]), centre_ - edge_[e01]);
    const Long radius = std::sqrt(long_of(query::dot(centre_, centre_)));
    for (Long& spread : spread_) spread *= 4 * flatness_ * radius;
  }

  // F, of two vertices; infinite, negative or NaN when rounding left nothing of the volume.
  Long flatness() const { return flatness_; }

  // The part of a vertex.
  VoronoiPart<Number> of(std::size_t vertex) const {
    static constexpr std::size_t edges[4][3] = {{e01, e02, e03}, {e01, e12, e13}, {e02, e12, e23}, {e03, e13, e23}};
    static constexpr bool ends_here[4][3] = {
        {false, false, false}, {true, false, false}, {true, true, false}, {true, true, true}};
    VoronoiPart<Number> part;
    Vec along;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t e = edges[vertex][i];
      part.volume += on_edge_[e];
      part.surface += 6 * on_edge_[e] / length_[e];
      along = along + (ends_here[vertex][i] ? Number(-on_edge_[e]) : on_edge_[e]) * edge_[e];
    }
    const Vec to_centre = vertex == 0 ? centre_ : centre_ - edge_[vertex - 1];
    part.moment = (2 * part.volume) * to_centre + Number(0.5L) * along - leaning_[vertex];
    part.moment = Number(0.25L) * part.moment;
    part.doubt = spread_[vertex];
    return part;
  }

 private:
  enum Edge : std::size_t { e01, e02, e03, e12, e13, e23 };

  static Vec minus(const Vec& a) { return {-a.x, -a.y, -a.z}; }

  // The facet of the vertices i, j and k, with its edges ij, ik and jk as numbers and as vectors; `normal` is ij x ik,
  // and `centre` is relative to i.
  void add_facet(const std::array<std::size_t, 3>& vertices, const std::array<std::size_t, 3>& edges, const Vec& ij,
                 const Vec& ik, const Vec& jk, const Vec& normal, const Vec& centre) {
    const Number squared = query::dot(normal, normal), height = query::dot(centre, normal) / squared,
                 share = height / 24;
    const std::array<Number, 3> on{share * square_[edges[0]] * query::dot(ik, jk),
                                   -share * square_[edges[1]] * query::dot(ij, jk),
                                   share * square_[edges[2]] * query::dot(ij, ik)};
    for (std::size_t i = 0; i < 3; ++i) on_edge_[edges[i]] += on[i];
    // The circumcentre of the facet is P - height * normal.
    const std::array<Number, 3> lean{(on[0] + on[1]) * height, (on[0] + on[2]) * height, (on[1] + on[2]) * height};
    const Long around = long_of(square_[edges[0]]) * long_of(square_[edges[1]]) * long_of(square_[edges[2]]) /
                        (2 * long_of(squared));  // 2 r^2
    for (std::size_t i = 0; i < 3; ++i) {
      leaning_[vertices[i]] = leaning_[vertices[i]] + lean[i] * normal;
      spread_[vertices[i]] += around;
    }
  }

  std::array<Vec, 6> edge_;
  std::array<Number, 6> square_, length_, on_edge_{};
  Vec centre_;  // relative to the first corner
  std::array<Vec, 4> leaning_{};
  std::array<Long, 4> spread_{};
  Long flatness_ = 0;
};

}  // namespace tessera::voronoi

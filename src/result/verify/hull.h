// The hull of a result is the boundary of a convex body, and the cells fill it once.
//
// Four facts about the hull facets, each turned inwards by the cell behind it, are checked with exact arithmetic:
//  (1) every ridge is shared by exactly two of them, which run through it in opposite directions: a closed surface;
//  (2) no facet has a vertex of one chosen cell, the core, on its outer side: all face a point o inside the core;
//  (3) neighbouring facets are convex or coplanar;
//  (4) a ray from o meets exactly one facet, and inside it.
// By (2) the projection from o onto a sphere keeps the orientation of every facet; by (1) the facets at a ridge come to
// lie on either side of it, so the number of facets over a direction is the same everywhere outside the projected
// vertices and lower ridges, which do not separate; by (4) that number is one. So the surface is star-shaped, and by
// (3) convex. It is connected and a sphere: nothing needs to be counted. (Ridges that are convex and the Euler
// characteristic of a sphere would not be enough: the great icosahedron has both, and covers its centre seven times.)
// Every point inside is then covered by exactly as many positively oriented cells as the surface winds around it: one.
// Source: Mehlhorn, Näher, Seel, Seidel, Schilz, Schirra, Uhrig, Checking geometric programs, SoCG 1996.
//
// Coplanar hull facets need no test of their own: the tie rule perturbs the paraboloid's heights only, so the cells
// that pass the local test over a convex hull are the regular triangulation of all points, and what it induces on a
// flat part of the hull is that part's own.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/verify/place.h"

namespace tessera {

// A facet of a main cell with nothing behind it. The first `dimension` places of at and ids; orientation(at..., p) is
// positive for the points p of the cell's side.
struct HullFacet {
  std::array<Point, 3> at;
  std::array<PointId, 3> ids;
  Place cell;
};

struct Core {
  std::array<Point, 4> at;
  IdSet ids;
};

class Hull {
 public:
  Hull(int dimension, TileSource source, const std::filesystem::path& scratch, std::uint64_t memory_bytes,
       std::stop_token stop);
  // `cell`: the facet's own; that of the first facet becomes the core.
  Status add(const HullFacet& facet, const Core& cell);
  // After all facets: ridges and rays.
  Status finish();
  std::uint64_t facets() const { return facets_; }

 private:
  using Exact = boost::multiprecision::cpp_rational;
  // Through o, a point inside the core, and p, one inside the first facet.
  struct Ray {
    std::array<double, 3> o, p;
    std::array<Exact, 3> exact_o, exact_p;
    std::uint64_t hits = 0;
    bool through_ridge = false;  // met a facet's border: says nothing
  };
  struct Ridge {
    std::array<PointId, 2> ids;
    HullFacet facet;
    std::uint8_t opposite;  // the facet's vertex that is not on the ridge
    bool ascending;         // the direction in which the facet runs through the ridge
    friend bool operator<(const Ridge& a, const Ridge& b) {
      if (a.ids != b.ids) return a.ids < b.ids;
      return a.facet.cell.tile != b.facet.cell.tile ? a.facet.cell.tile < b.facet.cell.tile
                                                    : a.facet.cell.cell < b.facet.cell.cell;
    }
  };

  int orientation(const HullFacet& facet, const Point& p) const;
  void aim(const HullFacet& facet);
  void count_hit(const HullFacet& facet, Ray& ray) const;
  // The side of the ray's line on which the points lie: sign of det(p - o, u - o[, v - o]).
  int side(const Ray& ray, const Point& u, const Point& v) const;
  Status check_ridge(std::span<const Ridge> group) const;
  Error wrong_facet(const HullFacet& facet, const std::string& reason) const;

  int dimension_;
  TileSource source_;
  std::uint64_t facets_ = 0;
  std::optional<Core> core_;
  std::vector<Ray> rays_;
  ExternalSort<Ridge> ridges_;
};

}  // namespace tessera

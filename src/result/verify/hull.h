// Checks that the hull of a result is the boundary of a convex body, and that the cells fill this body once.
//
// Hull facets are oriented inwards by the cells behind them. Exact arithmetic checks four facts:
//  (1) Every ridge belongs to exactly two facets, which run through it in opposite directions. So the surface is
//      closed.
//  (2) No facet has a vertex of one chosen cell, the core, on its outer side. So all facets face a point o inside the
//      core.
//  (3) Neighbouring facets are convex or coplanar.
//  (4) A ray from o meets exactly one facet, and meets it in its interior.
//
// By (2) the projection from o onto a sphere keeps the orientation of every facet. By (1) the two facets at a ridge are
// projected to different sides of the ridge. So the number of facets over a direction is the same everywhere outside
// the projected vertices and lower ridges, which do not separate the sphere. By (4) that number is one. So the surface
// is star-shaped, and by (3) convex. It follows that the surface is connected and a sphere, so nothing needs to be
// counted. (Convex ridges and the Euler characteristic of a sphere would not be enough: the great icosahedron has both,
// and covers its centre seven times.) Every point inside is then covered by as many positively oriented cells as the
// surface winds around it: one. Source: Mehlhorn, Näher, Seel, Seidel, Schilz, Schirra, Uhrig, Checking geometric
// programs, SoCG 1996.
//
// Coplanar hull facets need no test of their own. The tie rule perturbs only the heights of the paraboloid. So cells
// that pass the local test over a convex hull are the regular triangulation of all points, and the triangulation that
// they induce on a flat part of the hull is the regular triangulation of that part.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/verify/cell_ref.h"

namespace tessera {

// A facet of a main cell with no cell behind it. The first `dimension` entries of `at` and `ids` are used;
// orientation(at..., p) is positive for points p on the cell's side.
struct HullFacet {
  std::array<Point, 3> at;
  std::array<PointId, 3> ids;
  CellRef cell;
};

struct Core {
  std::array<Point, 4> at;
  IdSet ids;
};

class Hull {
 public:
  Hull(int dimension, TileSource source, const std::filesystem::path& scratch, std::uint64_t memory_bytes,
       std::stop_token stop);
  // Adds a facet with its cell. The cell of the first facet becomes the core.
  Status add(const HullFacet& facet, const Core& cell);
  // Call this after all facets: checks ridges and rays.
  Status finish();
  std::uint64_t facets() const { return facets_; }

 private:
  using Exact = boost::multiprecision::cpp_rational;
  // The ray through o, a point inside the core, and p, a point inside the first facet.
  struct Ray {
    std::array<double, 3> o, p;
    std::array<Exact, 3> exact_o, exact_p;
    std::uint64_t hits = 0;
    bool through_ridge = false;  // the ray meets a facet's border, so it proves nothing
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
  // The side of the ray's line on which the points lie: the sign of det(p - o, u - o[, v - o]).
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

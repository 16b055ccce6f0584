#include "src/result/measure/hull_volume.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/measure/exact_volume.h"
#include "src/result/query/hull.h"

namespace tessera {
namespace {

// The convex hull of points in space.
class SpaceHull {
 public:
  // REQUIRES: the corners span space.
  explicit SpaceHull(const std::vector<Point>& simplex) { add(simplex); }

  // REQUIRES: `points` and the corners so far span space.
  void add(const std::vector<Point>& points) {
    std::vector<Kernel::Point_3> all;
    all.reserve(points.size() + corners_.size());
    for (const auto& some : {corners_, points}) {
      for (const Point& p : some) all.emplace_back(p.x, p.y, p.z);
    }
    CGAL::Surface_mesh<Kernel::Point_3> hull;
    CGAL::convex_hull_3(all.begin(), all.end(), hull);
    corners_.clear();
    facets_.clear();
    std::vector<std::size_t> place(hull.number_of_vertices());
    for (const auto v : hull.vertices()) {
      const auto& p = hull.point(v);
      place[v] = corners_.size();
      corners_.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto f : hull.faces()) {
      std::vector<std::size_t> around;
      for (const auto v : CGAL::vertices_around_face(hull.halfedge(f), hull)) around.push_back(place[v]);
      for (std::size_t k = 2; k < around.size(); ++k) facets_.push_back({around[0], around[k - 1], around[k]});
    }
  }

  // Whether the closed hull contains the box.
  bool covers(const Bounds& box) const {
    for (unsigned corner = 0; corner < 8; ++corner) {
      Point p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = (corner >> static_cast<unsigned>(axis) & 1U) ? box.hi[axis] : box.lo[axis];
      for (const auto& [a, b, c] : facets_) {
        if (exact::orientation_3(corners_[a], corners_[b], corners_[c], p) > 0) return false;
      }
    }
    return true;
  }

  // Six times the volume: that of the simplices from a corner to all facets, which face outwards.
  ScaledInteger volume_times_six() const {
    ExactSum sum;
    for (const auto& [a, b, c] : facets_)
      sum.add(volume_times_factorial(std::array{corners_[0], corners_[a], corners_[b], corners_[c]}));
    return sum.value();
  }

 private:
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Point> corners_;
  std::vector<std::array<std::size_t, 3>> facets_;  // counterclockwise, seen from outside
};

// The corners of any cell.
Result<std::vector<Point>> any_cell(const TileSource& source) {
  std::size_t smallest = 0;
  for (std::size_t i = 1; i < source.tiles(); ++i) {
    if (source.entry(i).points < source.entry(smallest).points) smallest = i;
  }
  BOOST_OUTCOME_TRY(stored, source.read(smallest, {}));
  std::vector<Point> corners;
  for (std::size_t k = 0; k < std::min<std::size_t>(4, stored.mesh.cells.size()); ++k)
    corners.push_back(stored.mesh.points[static_cast<std::size_t>(stored.mesh.cells[k])]);
  if (corners.size() < 4) return error(Errc::corrupt, source.file(smallest).string() + ": has points and no cell");
  return corners;
}

// The tiles, those that reach the border of the whole first, because their points make most other tiles unnecessary.
std::vector<std::size_t> outermost_first(const TileSource& source) {
  const Bounds& bounds = source.manifest().bounds;
  std::vector<std::pair<int, std::size_t>> order;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const Bounds box = query::box_of(source.manifest(), source.entry(i).tile);
    int inside = 0;
    for (int axis = 0; axis < 3; ++axis)
      inside += (box.lo[axis] > bounds.lo[axis] ? 1 : 0) + (box.hi[axis] < bounds.hi[axis] ? 1 : 0);
    order.emplace_back(inside, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> tiles;
  for (const auto& [inside, i] : order) tiles.push_back(i);
  return tiles;
}

Result<double> volume_in_space(const TileSource& source, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(simplex, any_cell(source));
  SpaceHull hull(simplex);
  for (const std::size_t i : outermost_first(source)) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while looking for the hull");
    if (hull.covers(query::box_of(source.manifest(), source.entry(i).tile))) continue;
    BOOST_OUTCOME_TRY(stored, source.read(i, {.cells = false}));
    hull.add(stored.mesh.points);
  }
  return rounded_quotient(hull.volume_times_six(), 6);
}

Result<double> area_in_plane(const TileSource& source, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(hull, query::hull_of(source, stop));
  ExactSum sum;
  for (std::size_t k = 2; k < hull.size(); ++k)
    sum.add(volume_times_factorial(std::array{hull[0], hull[k - 1], hull[k]}));
  return rounded_quotient(sum.value(), 2);
}

}  // namespace

Result<double> volume_of_hull(const TileSource& source, const std::stop_token& stop) {
  return source.manifest().dimension == 2 ? area_in_plane(source, stop) : volume_in_space(source, stop);
}

Status renew_totals(const TileSource& whole, std::vector<ResultColumn>& columns, const std::stop_token& stop) {
  std::optional<double> volume;
  for (ResultColumn& column : columns) {
    if (!column.total) continue;
    if (!volume) {
      BOOST_OUTCOME_TRY(computed, volume_of_hull(whole.stopped_by(stop), stop));
      volume = computed;
    }
    column.total = volume;
  }
  return success();
}

}  // namespace tessera

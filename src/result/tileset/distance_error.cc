#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "src/result/tileset/surface.h"

namespace tessera::tileset {
namespace {

namespace geometry = boost::geometry;
using Place = geometry::model::point<double, 3, geometry::cs::cartesian>;
using Box = geometry::model::box<Place>;
using Entry = std::pair<Box, std::uint32_t>;  // with the number of its triangle
using Tree = geometry::index::rtree<Entry, geometry::index::rstar<16>>;

Place place(const Point& p) { return {p.x, p.y, p.z}; }
Point minus(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Point along(const Point& a, double t, const Point& b) { return {a.x + t * b.x, a.y + t * b.y, a.z + t * b.z}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double square_to_segment(const Point& p, const Point& a, const Point& b) {
  const Point ab = minus(b, a), ap = minus(p, a);
  const double length = dot(ab, ab);
  const double t = length > 0 ? std::min(std::max(dot(ap, ab) / length, 0.0), 1.0) : 0;
  const Point d = minus(p, along(a, t, ab));
  return dot(d, d);
}

// The squared distance to the plane, when p is above or below the triangle; else to the nearest edge.
double square_to_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Point normal = cross(minus(b, a), minus(c, a));
  const double square = dot(normal, normal);
  const auto inside = [&](const Point& from, const Point& to) {
    return dot(cross(minus(to, from), minus(p, from)), normal) >= 0;
  };
  if (square > 0 && inside(a, b) && inside(b, c) && inside(c, a)) {
    const double height = dot(minus(p, a), normal);
    return height * height / square;
  }
  return std::min({square_to_segment(p, a, b), square_to_segment(p, b, c), square_to_segment(p, c, a)});
}

Tree tree_of(const Surface& surface) {
  std::vector<Entry> entries;
  entries.reserve(surface.triangles());
  for (std::uint32_t t = 0; t < surface.triangles(); ++t) {
    Bounds box;
    for (std::size_t k = 0; k < 3; ++k) box.add(surface.vertices[surface.corners[3 * std::size_t{t} + k]].at);
    entries.emplace_back(Box(place(box.lo), place(box.hi)), t);
  }
  return Tree(entries);
}

double square_to_surface(const Point& p, const Surface& surface, const Tree& tree, std::vector<Entry>& found) {
  const Place at = place(p);
  for (std::size_t most = 8;; most *= 4) {
    found.clear();
    tree.query(geometry::index::nearest(at, static_cast<unsigned>(std::min(most, tree.size()))),
               std::back_inserter(found));
    double nearest = std::numeric_limits<double>::infinity(), farthest_box = 0;
    for (const auto& [box, triangle] : found) {
      const std::uint32_t* corner = &surface.corners[3 * std::size_t{triangle}];
      nearest = std::min(nearest, square_to_triangle(p, surface.vertices[corner[0]].at, surface.vertices[corner[1]].at,
                                                     surface.vertices[corner[2]].at));
      farthest_box = std::max(farthest_box, geometry::comparable_distance(at, box));
    }
    // No box that was not found is nearer than the boxes that were.
    if (found.size() == tree.size() || nearest <= farthest_box) return nearest;
  }
}

}  // namespace

double distance_error(const Surface& fine, const Surface& coarse) {
  if (fine.vertices.empty() || coarse.triangles() == 0) return 0;
  const Tree tree = tree_of(coarse);
  std::vector<Entry> found;
  double sum = 0;
  for (const SurfaceVertex& v : fine.vertices) sum += square_to_surface(v.at, coarse, tree, found);
  return std::sqrt(sum / static_cast<double>(fine.vertices.size()));
}

}  // namespace tessera::tileset

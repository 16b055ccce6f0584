#include "src/result/region/meets.h"

#include <algorithm>
#include <array>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/region/corners.h"

namespace tessera {
namespace {

bool is_inside(const Point& p, const Bounds& box, int dimension) {
  for (int axis = 0; axis < dimension; ++axis)
    if (p[axis] < box.lo[axis] || p[axis] > box.hi[axis]) return false;
  return true;
}

// The point p without its coordinate `axis`.
Point flat(const Point& p, int axis) {
  return axis == 0 ? Point{p.y, p.z} : axis == 1 ? Point{p.x, p.z} : Point{p.x, p.y};
}

// True if the plane of facet `k` (in 2D its line) has the whole box strictly on the side away from the cell.
bool facet_separates(std::span<const Point> cell, std::size_t k, const Corners& corners) {
  std::array<Point, 4> simplex{};
  std::copy(cell.begin(), cell.end(), simplex.begin());
  return std::all_of(corners.begin(), corners.end(), [&](const Point& corner) {
    simplex[k] = corner;
    return (cell.size() == 4 ? exact::orientation_3(simplex[0], simplex[1], simplex[2], simplex[3])
                             : exact::orientation_2(simplex[0], simplex[1], simplex[2])) < 0;
  });
}

// The same for the plane through edge (i, j) parallel to an axis, seen along that axis.
bool edge_separates(std::span<const Point> cell, std::size_t i, std::size_t j, int axis, const Bounds& box) {
  const Point a = flat(cell[i], axis), b = flat(cell[j], axis);
  if (a == b) return false;
  const Point lo = flat(box.lo, axis), hi = flat(box.hi, axis);
  const int side = exact::orientation_2(a, b, lo);
  if (side == 0) return false;
  for (const Point& corner : {Point{lo.x, hi.y}, Point{hi.x, lo.y}, hi})
    if (exact::orientation_2(a, b, corner) != side) return false;
  for (std::size_t k = 0; k < 4; ++k)
    if (k != i && k != j && exact::orientation_2(a, b, flat(cell[k], axis)) == side) return false;
  return true;
}

}  // namespace

bool meets(std::span<const Point> cell, const Bounds& box) {
  const int dimension = static_cast<int>(cell.size()) - 1;
  for (int axis = 0; axis < dimension; ++axis) {
    double least = cell[0][axis], most = least;
    for (const Point& p : cell) least = std::min(least, p[axis]), most = std::max(most, p[axis]);
    if (most < box.lo[axis] || least > box.hi[axis]) return false;
  }
  if (std::any_of(cell.begin(), cell.end(), [&](const Point& p) { return is_inside(p, box, dimension); })) return true;
  const Corners corners = corners_of(box, dimension);
  for (std::size_t k = 0; k < cell.size(); ++k)
    if (facet_separates(cell, k, corners)) return false;
  if (dimension == 2) return true;
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        if (edge_separates(cell, i, j, axis, box)) return false;
  return true;
}

}  // namespace tessera

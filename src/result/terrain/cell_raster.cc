#include "src/result/terrain/cell_raster.h"

#include <boost/multiprecision/cpp_int.hpp>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/query/area.h"

namespace tessera::terrain {
namespace {

// Twice the area of (q, a, b) as left - right, which also bounds the error.
template <class Number>
struct Area {
  Number left, right;
  Area(const Point& q, const Point& a, const Point& b)
      : left((Number(a.x) - Number(q.x)) * (Number(b.y) - Number(q.y))),
        right((Number(b.x) - Number(q.x)) * (Number(a.y) - Number(q.y))) {}
  Number area() const { return left - right; }
};

// A corner with weight 0 is ignored, whatever its value, which may be NaN.
double mix(const Triangle& cell, double a, double b, double c) {
  double value = 0;
  const double parts[] = {a, b, c};
  for (std::size_t k = 0; k < 3; ++k)
    if (parts[k] > 0) value += parts[k] * cell[k].value;
  return value;
}

double value_exactly(const Triangle& cell, const Point& q) {
  using Exact = boost::multiprecision::cpp_rational;
  const Exact a = Area<Exact>(q, cell[1].at, cell[2].at).area();
  const Exact b = Area<Exact>(q, cell[2].at, cell[0].at).area();
  const Exact c = Area<Exact>(q, cell[0].at, cell[1].at).area();
  const Exact whole = a + b + c;
  const auto part = [&](const Exact& area) { return static_cast<double>(Exact(area / whole)); };
  return mix(cell, part(a), part(b), part(c));
}

}  // namespace

bool has_pixel(const Triangle& cell, const Point& centre) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Point &a = cell[k].at, &b = cell[k == 2 ? 0 : k + 1].at;
    const int side = exact::orientation_2(a, b, centre);
    if (side < 0) return false;
    // The moved centre is inside for an edge that goes down, or horizontally to the right.
    if (side == 0 && !(b.y < a.y || (b.y == a.y && b.x > a.x))) return false;
  }
  return true;
}

double value_at(const Triangle& cell, const Point& q) {
  const Area<double> a(q, cell[1].at, cell[2].at), b(q, cell[2].at, cell[0].at), c(q, cell[0].at, cell[1].at);
  const double whole = a.area() + b.area() + c.area();
  // Each difference, product and sum rounds once (exact::filter), so areas are off by at most 4 u (|left| + |right|).
  const double error = 0x1p-50 * (std::abs(a.left) + std::abs(a.right) + std::abs(b.left) + std::abs(b.right) +
                                  std::abs(c.left) + std::abs(c.right));
  const double size = std::abs(whole);
  if (!(error < 1e-12 * size && size > 1e-250)) return value_exactly(cell, q);
  const auto part = [&](const Area<double>& area) { return std::clamp(area.area() / whole, 0.0, 1.0); };
  return mix(cell, part(a), part(b), part(c));
}

Status for_each_part_of_large(const Grid& grid, const Triangle& cell, const std::function<Status(const Grid&)>& visit) {
  Bounds around;
  for (const Corner& corner : cell) around.add(corner.at);
  // One pixel more on all sides, which only costs time.
  const auto from = [&](double c, std::int64_t least) {
    return std::max(least, static_cast<std::int64_t>(std::floor(c / grid.res)) - 1);
  };
  const auto to = [&](double c, std::int64_t end) {
    return std::min(end, static_cast<std::int64_t>(std::ceil(c / grid.res)) + 1);
  };
  const std::int64_t left = from(around.lo.x, grid.column0), right = to(around.hi.x, grid.column0 + grid.width);
  const std::int64_t low = from(around.lo.y, grid.row0), high = to(around.hi.y, grid.row0 + grid.height);
  if (right - left <= part_side && high - low <= part_side) return visit(grid);
  const std::array<Point, 3> corners{cell[0].at, cell[1].at, cell[2].at};
  Grid part = grid;
  for (part.row0 = low; part.row0 < high; part.row0 += part_side) {
    part.height = std::min(part_side, high - part.row0);
    for (part.column0 = left; part.column0 < right; part.column0 += part_side) {
      part.width = std::min(part_side, right - part.column0);
      const Bounds box{{grid.centre(part.column0 - 1), grid.centre(part.row0 - 1), 0},
                       {grid.centre(part.column0 + part.width), grid.centre(part.row0 + part.height), 0}};
      if (!query::meets(corners, box)) continue;
      BOOST_OUTCOME_TRYV(visit(part));
    }
  }
  return success();
}

}  // namespace tessera::terrain

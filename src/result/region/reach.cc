#include "src/result/region/reach.h"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <vector>

#include "src/base/ieee_arithmetic.h"
#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/region/corners.h"

namespace tessera {
namespace {

using Number =
    boost::multiprecision::number<boost::multiprecision::cpp_rational_backend, boost::multiprecision::et_off>;
using Vector = std::array<Number, 3>;

Vector minus(const Point& p, const Point& q) {
  return {Number(p.x) - Number(q.x), Number(p.y) - Number(q.y), Number(p.z) - Number(q.z)};
}
Number dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The centre relative to the first vertex, as in src/tiling/tile/circumsphere.cc.
Vector centre(const std::array<Point, 4>& cell, int dimension) {
  const Vector u = minus(cell[1], cell[0]), v = minus(cell[2], cell[0]);
  const Number uu = dot(u, u), vv = dot(v, v);
  if (dimension == 2) {
    const Number twice = 2 * (u[0] * v[1] - u[1] * v[0]);
    return {(uu * v[1] - vv * u[1]) / twice, (vv * u[0] - uu * v[0]) / twice, 0};
  }
  const Vector w = minus(cell[3], cell[0]), vw = cross(v, w), wu = cross(w, u), uv = cross(u, v);
  const Number twice = 2 * dot(u, vw), ww = dot(w, w);
  Vector o;
  for (std::size_t i = 0; i < 3; ++i) o[i] = (uu * vw[i] + vv * wu[i] + ww * uv[i]) / twice;
  return o;
}

bool meets_exactly(const std::array<Point, 4>& cell, const Bounds& box, int dimension) {
  const Vector o = centre(cell, dimension), lo = minus(box.lo, cell[0]), hi = minus(box.hi, cell[0]);
  Number distance = 0;
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(dimension); ++axis) {
    Number beside = 0;
    if (o[axis] < lo[axis]) beside = lo[axis] - o[axis];
    if (o[axis] > hi[axis]) beside = o[axis] - hi[axis];
    distance += beside * beside;
  }
  return distance <= dot(o, o);
}

Ball ball_of(std::span<const Point> cell) {
  return cell.size() == 4 ? circumsphere(cell[0], cell[1], cell[2], cell[3]) : circumcircle(cell[0], cell[1], cell[2]);
}

}  // namespace

SphereReach::SphereReach(std::span<const Point> cell)
    : dimension_(static_cast<int>(cell.size()) - 1), ball_(ball_of(cell)) {
  std::copy(cell.begin(), cell.end(), cell_.begin());
}

// A difference is off by at most e = 2^-53 of itself, a square by 3e, the sum of three squares by 5e. So 16e cover all
// of these and the square of the radius. Squares that underflow are below 1e-307: the last term keeps distances that
// small from counting as apart.
bool SphereReach::meets(const Bounds& box) const {
  if (!ball_.known) return meets_exactly(cell_, box, dimension_);
  constexpr double eps = 0x1p-53;
  double distance = 0;
  for (int axis = 0; axis < dimension_; ++axis) {
    const double beside = std::max({box.lo[axis] - ball_.center[axis], ball_.center[axis] - box.hi[axis], 0.0});
    distance += beside * beside;
  }
  return !(distance * (1 - 16 * eps) > ball_.radius * ball_.radius * (1 + 16 * eps) + 1e-300);
}

HullReach::HullReach(std::span<const Point> cell, std::size_t infinite)
    : dimension_(static_cast<int>(cell.size()) - 1), infinite_(infinite) {
  std::copy(cell.begin(), cell.end(), cell_.begin());
}

int HullReach::side(const Bounds& box) const {
  std::array<Point, 4> simplex = cell_;
  int greatest = -1;
  for (const Point& corner : corners_of(box, dimension_)) {
    simplex[infinite_] = corner;
    greatest = std::max(greatest, dimension_ == 3 ? exact::orientation_3(simplex[0], simplex[1], simplex[2], simplex[3])
                                                  : exact::orientation_2(simplex[0], simplex[1], simplex[2]));
    if (greatest > 0) break;
  }
  return greatest;
}

}  // namespace tessera

#include "src/result/density/linear.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/result/query/dual.h"

namespace tessera::density {
namespace {

using query::cross;
using query::dot;
using query::Long;
using query::Vec;
using query::Wide;

constexpr Long rounding = 64 * std::numeric_limits<Long>::epsilon();  // of a few dozen operations

// The gradients of the functions of vertices 1..d, times the determinant of the edges from vertex 0.
template <class Number>
std::array<Vec<Number>, 3> cofactors(std::span<const Vec<Number>> edges) {
  if (edges.size() == 2)
    return {Vec<Number>{edges[1].y, -edges[1].x, 0}, Vec<Number>{-edges[0].y, edges[0].x, 0}, Vec<Number>{}};
  return {cross(edges[1], edges[2]), cross(edges[2], edges[0]), cross(edges[0], edges[1])};
}

template <class Number>
std::array<Vec<Number>, 3> edges_of(std::span<const Point> corners) {
  std::array<Vec<Number>, 3> edges;
  for (std::size_t k = 1; k < corners.size(); ++k) edges[k - 1] = query::relative<Number>(corners[k], corners[0]);
  return edges;
}

template <class Number>
Number component(const Vec<Number>& v, std::size_t axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

Long largest(const Vec<Long>& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// By which facets weights are: d! times the signed volumes of the place with each facet.
template <class Number>
std::array<Number, 4> volumes_at(std::span<const Point> corners, const Point& place) {
  std::array<Vec<Number>, 4> to;
  for (std::size_t k = 0; k < corners.size(); ++k) to[k] = query::relative<Number>(corners[k], place);
  std::array<Number, 4> volumes{};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const auto corner = [&](std::size_t i) -> const Vec<Number>& {
      return to[query::facet_corner(corners.size(), k, i)];
    };
    volumes[k] = corners.size() == 4 ? Number(dot(corner(0), cross(corner(1), corner(2))))
                                     : Number(corner(0).x * corner(1).y - corner(0).y * corner(1).x);
  }
  return volumes;
}

template <class Number>
std::array<double, 4> shares_of(const std::array<Number, 4>& volumes) {
  const Number whole = volumes[0] + volumes[1] + volumes[2] + volumes[3];
  std::array<double, 4> weights{};
  for (std::size_t k = 0; k < weights.size(); ++k)
    weights[k] = std::clamp(static_cast<double>(Number(volumes[k] / whole)), 0.0, 1.0);
  return weights;
}

ScaledDouble scaled(const Long& number) {
  int exponent = 0;
  const Long fraction = std::frexp(number, &exponent);
  return ScaledDouble::of(static_cast<double>(fraction), exponent);
}
ScaledDouble scaled(const Wide& number) {
  int exponent = 0;
  const Wide fraction = frexp(number, &exponent);
  return ScaledDouble::of(static_cast<double>(fraction), exponent);
}

template <class Number>
std::array<ScaledDouble, 3> gradient(std::span<const double> values, const std::array<Vec<Number>, 3>& gradients) {
  std::array<ScaledDouble, 3> sums;
  for (std::size_t axis = 0; axis + 1 < values.size(); ++axis) {
    Number sum = 0;
    for (std::size_t k = 1; k < values.size(); ++k)
      sum += (Number(values[k]) - Number(values[0])) * component(gradients[k - 1], axis);
    sums[axis] = scaled(sum);
  }
  return sums;
}

}  // namespace

VoxelWeights::VoxelWeights(const VoxelGrid& grid, std::span<const Point> corners,
                           const std::array<std::int64_t, 3>& base)
    : corners_(corners.size()), base_(base) {
  const std::size_t d = corners.size() - 1;
  const auto edges = edges_of<Wide>(corners);
  const auto gradients = cofactors<Wide>(std::span(edges).first(d));
  const Wide whole = dot(edges[0], gradients[0]);
  at_base_[0] = 1;
  Wide rest = 1;
  std::array<Wide, 3> rest_step{};
  for (std::size_t k = 1; k < corners_; ++k) {
    Wide value = 0;
    for (std::size_t axis = 0; axis < d; ++axis) {
      const Wide slope = component(gradients[k - 1], axis) / whole;
      const VoxelAxis& line = grid.axes[axis];
      const Wide width = Wide(line.length) / Wide(static_cast<double>(line.count));
      const Wide centre = Wide(line.origin) + (Wide(static_cast<double>(base[axis])) + Wide(0.5)) * width;
      value += slope * (centre - Wide(corners[0][static_cast<int>(axis)]));
      step_[k][axis] = static_cast<Long>(Wide(slope * width));
      rest_step[axis] -= slope * width;
    }
    at_base_[k] = static_cast<Long>(value);
    rest -= value;
  }
  at_base_[0] = static_cast<Long>(rest);
  for (std::size_t axis = 0; axis < d; ++axis) step_[0][axis] = static_cast<Long>(rest_step[axis]);
  for (std::size_t k = 0; k < corners_; ++k)
    for (const Long step : step_[k]) half_[k] += std::abs(step) / 2;
}

long double VoxelWeights::weight(std::size_t k, const std::array<std::int64_t, 3>& at) const {
  Long weight = at_base_[k];
  for (std::size_t axis = 0; axis + 1 < corners_; ++axis)
    weight += static_cast<Long>(at[axis] - base_[axis]) * step_[k][axis];
  return weight;
}

bool VoxelWeights::has_voxel(const std::array<std::int64_t, 3>& at) const {
  for (std::size_t k = 0; k < corners_; ++k) {
    Long size = std::abs(at_base_[k]) + half_[k];
    for (std::size_t axis = 0; axis + 1 < corners_; ++axis)
      size += std::abs(static_cast<Long>(at[axis] - base_[axis]) * step_[k][axis]);
    if (!(weight(k, at) - half_[k] > rounding * size)) return false;
  }
  return true;
}

std::array<double, 4> VoxelWeights::weights(const std::array<std::int64_t, 3>& at) const {
  std::array<double, 4> weights{};
  for (std::size_t k = 0; k < corners_; ++k) weights[k] = static_cast<double>(weight(k, at));
  return weights;
}

CellAtPoint::CellAtPoint(std::span<const Point> corners, std::span<const std::uint8_t> oriented) : corners_(corners) {
  for (std::size_t k = 0; k < corners.size(); ++k) {
    oriented_[k] = corners[oriented[k]];
    bounds_.add(corners[k]);
  }
}

bool CellAtPoint::has(const Point& place) const {
  for (int axis = 0; axis < 3; ++axis)
    if (place[axis] < bounds_.lo[axis] || place[axis] > bounds_.hi[axis]) return false;
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    const auto corner = [&](std::size_t i) -> const Point& {
      return oriented_[query::facet_corner(corners_.size(), k, i)];
    };
    const Point &a = corner(0), &b = corner(1);
    if (corners_.size() == 3) {
      const int side = exact::orientation_2(a, b, place);
      if (side < 0 || (side == 0 && !(b.y < a.y || (b.y == a.y && b.x > a.x)))) return false;
      continue;
    }
    const Point& c = corner(2);
    int side = exact::orientation_3(a, b, c, place);
    // On the facet the step decides: the signs of the components of the facet's normal, which points inside.
    const auto turned = [](const Point& p, int x, int y) { return Point{p[x], p[y], 0}; };
    constexpr int planes[3][2] = {{1, 2}, {2, 0}, {0, 1}};
    for (int axis = 0; side == 0 && axis < 3; ++axis) {
      const auto [x, y] = planes[axis];
      side = exact::orientation_2(turned(a, x, y), turned(b, x, y), turned(c, x, y));
    }
    if (side < 0) return false;
  }
  return true;
}

std::array<double, 4> CellAtPoint::weights(const Point& place) const {
  const auto volumes = volumes_at<Long>(corners_, place);
  const Long whole = std::abs(volumes[0] + volumes[1] + volumes[2] + volumes[3]);
  Long farthest = 0, doubt = 1;
  for (const Point& p : corners_) farthest = std::max(farthest, largest(query::relative<Long>(p, place)));
  for (std::size_t i = 0; i + 1 < corners_.size(); ++i) doubt *= farthest;
  if (rounding * doubt <= 1e-15L * whole) return shares_of(volumes);
  return shares_of(volumes_at<Wide>(corners_, place));
}

std::array<ScaledDouble, 3> gradient_times_volume(std::span<const Point> corners, std::span<const double> values) {
  const std::size_t d = corners.size() - 1;
  const auto edges = edges_of<Long>(corners);
  const auto gradients = cofactors<Long>(std::span(edges).first(d));
  bool sure = true;
  for (std::size_t k = 0; d == 3 && k < d; ++k) {
    const Long doubt = largest(edges[(k + 1) % 3]) * largest(edges[(k + 2) % 3]);
    sure = sure && rounding * doubt <= 1e-15L * largest(gradients[k]);
  }
  if (sure) return gradient<Long>(values, gradients);
  const auto wide = edges_of<Wide>(corners);
  return gradient<Wide>(values, cofactors<Wide>(std::span(wide).first(d)));
}

}  // namespace tessera::density

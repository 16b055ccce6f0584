#include "src/result/measure/cell_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tessera {
namespace {

Point minus(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(const Point& a) { return std::hypot(a.x, a.y, a.z); }
double degrees(double radians) { return radians * (180 / std::numbers::pi); }

// The corners relative to the first one, divided by the power of two 2^exponent that brings the longest edge near 1. So
// products of lengths neither overflow nor vanish.
struct Scaled {
  std::array<Point, 4> at{};
  int exponent = 0;
};

Scaled scaled(std::span<const Point> corners) {
  Scaled made;
  double most = 0;
  for (std::size_t k = 1; k < corners.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      // Halves: the difference of two finite numbers may be too large for a double.
      const double half = corners[k][axis] / 2 - corners[0][axis] / 2;
      made.at[k][axis] = half;
      most = std::max(most, std::abs(half));
    }
  }
  const int half_exponent = most > 0 ? std::ilogb(most) : 0;
  for (std::size_t k = 1; k < corners.size(); ++k)
    for (int axis = 0; axis < 3; ++axis) made.at[k][axis] = std::ldexp(made.at[k][axis], -half_exponent);
  made.exponent = half_exponent + 1;
  return made;
}

// d! times the volume of the scaled cell, rounded once.
double volume_of(const ScaledInteger& exact, const Scaled& cell, int dimension) {
  ScaledInteger number = exact;
  number.exponent -= dimension * cell.exponent;
  return std::abs(rounded_quotient(number, 1));
}

CellQuality of_triangle(const Scaled& cell, double area2) {
  const auto& p = cell.at;
  std::array<double, 3> edge{};  // opposite each corner
  for (std::size_t k = 0; k < 3; ++k) edge[k] = length(minus(p[(k + 1) % 3], p[(k + 2) % 3]));
  const double circumradius = edge[0] * edge[1] * edge[2] / (2 * area2);
  const double inradius = area2 / (edge[0] + edge[1] + edge[2]);
  CellQuality quality{.radius_ratio = std::min(1.0, 2 * inradius / circumradius),
                      .least_angle = 180,
                      .largest_angle = 0,
                      .circumradius = std::ldexp(circumradius, cell.exponent)};
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = degrees(std::atan2(area2, dot(minus(p[(k + 1) % 3], p[k]), minus(p[(k + 2) % 3], p[k]))));
    quality.least_angle = std::min(quality.least_angle, angle);
    quality.largest_angle = std::max(quality.largest_angle, angle);
  }
  return quality;
}

CellQuality of_tetrahedron(const Scaled& cell, double volume6) {
  const auto& p = cell.at;
  const Point bc = cross(p[2], p[3]), ca = cross(p[3], p[1]), ab = cross(p[1], p[2]);
  Point centre;  // of the circumsphere, times twice the volume
  for (int axis = 0; axis < 3; ++axis)
    centre[axis] = dot(p[1], p[1]) * bc[axis] + dot(p[2], p[2]) * ca[axis] + dot(p[3], p[3]) * ab[axis];
  const double circumradius = length(centre) / (2 * volume6);
  const double areas2 = length(bc) + length(ca) + length(ab) + length(cross(minus(p[2], p[1]), minus(p[3], p[1])));
  CellQuality quality{.radius_ratio = std::min(1.0, 3 * (volume6 / areas2) / circumradius),
                      .least_angle = 180,
                      .largest_angle = 0,
                      .circumradius = std::ldexp(circumradius, cell.exponent)};
  static constexpr std::size_t edges[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2},
                                              {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};
  for (const auto& [i, j, k, l] : edges) {
    const Point edge = minus(p[j], p[i]);
    const double cosine = dot(cross(edge, minus(p[k], p[i])), cross(edge, minus(p[l], p[i])));
    // The sine of the angle, times the areas of both facets and 4: the length of the edge times 6 volumes.
    const double angle = degrees(std::atan2(length(edge) * volume6, cosine));
    quality.least_angle = std::min(quality.least_angle, angle);
    quality.largest_angle = std::max(quality.largest_angle, angle);
  }
  return quality;
}

}  // namespace

CellQuality quality_of(std::span<const Point> corners, const ScaledInteger& exact) {
  const Scaled cell = scaled(corners);
  const int dimension = static_cast<int>(corners.size()) - 1;
  const double volume = volume_of(exact, cell, dimension);
  return dimension == 2 ? of_triangle(cell, volume) : of_tetrahedron(cell, volume);
}

}  // namespace tessera

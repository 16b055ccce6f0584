#include "src/result/measure/cell_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "src/result/query/dual.h"

namespace tessera {
namespace {

using query::cross;
using query::dot;
using query::Long;
using Edge = query::Vec<Long>;

Long length(const Edge& a) { return std::sqrt(dot(a, a)); }
double degrees(Long radians) { return static_cast<double>(radians * (180 / std::numbers::pi_v<Long>)); }

// The corners relative to the first one, divided by the power of two 2^exponent that brings the longest edge near 1. So
// products of lengths neither overflow nor vanish.
struct Scaled {
  std::array<Edge, 4> at{};
  int exponent = 0;
};

Scaled scaled(std::span<const Point> corners) {
  Scaled made;
  Long most = 0;
  for (std::size_t k = 1; k < corners.size(); ++k) {
    made.at[k] = query::relative<Long>(corners[k], corners[0]);
    most = std::max({most, std::abs(made.at[k].x), std::abs(made.at[k].y), std::abs(made.at[k].z)});
  }
  made.exponent = most > 0 ? std::ilogb(most) : 0;
  for (Edge& edge : made.at)
    edge = {std::ldexp(edge.x, -made.exponent), std::ldexp(edge.y, -made.exponent), std::ldexp(edge.z, -made.exponent)};
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
  std::array<Long, 3> edge{};  // opposite each corner
  for (std::size_t k = 0; k < 3; ++k) edge[k] = length(p[(k + 1) % 3] - p[(k + 2) % 3]);
  const Long circumradius = edge[0] * edge[1] * edge[2] / (2 * area2);
  const Long inradius = area2 / (edge[0] + edge[1] + edge[2]);
  CellQuality quality{.radius_ratio = static_cast<double>(std::min(Long(1), 2 * inradius / circumradius)),
                      .least_angle = 180,
                      .largest_angle = 0,
                      .circumradius = static_cast<double>(std::ldexp(circumradius, cell.exponent))};
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = degrees(std::atan2(area2, dot(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k])));
    quality.least_angle = std::min(quality.least_angle, angle);
    quality.largest_angle = std::max(quality.largest_angle, angle);
  }
  return quality;
}

CellQuality of_tetrahedron(const Scaled& cell, double volume6) {
  const auto& p = cell.at;
  const Edge bc = cross(p[2], p[3]), ca = cross(p[3], p[1]), ab = cross(p[1], p[2]);
  // The circumcentre, times twice the volume and 6.
  const Edge centre = dot(p[1], p[1]) * bc + dot(p[2], p[2]) * ca + dot(p[3], p[3]) * ab;
  const Long circumradius = length(centre) / (2 * volume6);
  const Long areas2 = length(bc) + length(ca) + length(ab) + length(cross(p[2] - p[1], p[3] - p[1]));
  CellQuality quality{.radius_ratio = static_cast<double>(std::min(Long(1), 3 * (volume6 / areas2) / circumradius)),
                      .least_angle = 180,
                      .largest_angle = 0,
                      .circumradius = static_cast<double>(std::ldexp(circumradius, cell.exponent))};
  static constexpr std::size_t edges[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2},
                                              {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};
  for (const auto& [i, j, k, l] : edges) {
    const Edge edge = p[j] - p[i];
    const Long cosine = dot(cross(edge, p[k] - p[i]), cross(edge, p[l] - p[i]));
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

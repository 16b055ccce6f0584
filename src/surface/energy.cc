#include "src/surface/energy.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "src/base/ieee_arithmetic.h"
#include "src/surface/cut/cut_graph.h"

namespace tessera::surface {

namespace {

Point minus(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <std::size_t n>
void sort_by_id(std::array<Corner, n>& corners) {
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) { return a.id < b.id; });
}

// Returns the cosine of the angle between the facet and the sphere around the cell of facet and `apex`, where the two
// meet. It is 1 when the sphere only touches the facet's plane from the apex's side. A flat cell has an infinite
// sphere, which says nothing: 0.
double cosine(const std::array<Corner, 3>& facet, const Corner& apex) {
  std::array<Corner, 4> cell{facet[0], facet[1], facet[2], apex};
  sort_by_id(cell);
  const Point b = minus(cell[1].at, cell[0].at), c = minus(cell[2].at, cell[0].at), d = minus(cell[3].at, cell[0].at);
  const Point cd = cross(c, d), db = cross(d, b), bc = cross(b, c);
  const double volume = 2 * dot(b, cd), bb = dot(b, b), cc = dot(c, c), dd = dot(d, d);
  // From the first corner to the centre.
  const Point to{(bb * cd.x + cc * db.x + dd * bc.x) / volume, (bb * cd.y + cc * db.y + dd * bc.y) / volume,
                 (bb * cd.z + cc * db.z + dd * bc.z) / volume};
  const double radius = std::sqrt(dot(to, to));
  Point normal = cross(minus(facet[1].at, facet[0].at), minus(facet[2].at, facet[0].at));
  const double length = std::sqrt(dot(normal, normal));
  const double towards = dot(normal, minus(apex.at, facet[0].at));
  const Point centre{cell[0].at.x + to.x - facet[0].at.x, cell[0].at.y + to.y - facet[0].at.y,
                     cell[0].at.z + to.z - facet[0].at.z};
  const double height = dot(normal, centre) / (length * radius);
  if (!std::isfinite(height)) return 0;
  return std::clamp(towards < 0 ? -height : height, -1.0, 1.0);
}

}  // namespace

double exp_of_minus(double x) {
  if (!(x < 40)) return 0;
  if (x <= 0) return 1;
  // e^-x = 2^-n e^-r, 0 <= r < ln 2. The series has 18 terms; the rest is below a unit of the last place. ln 2 is a sum
  // of two doubles, such that n times the first is exact.
  constexpr double ln2 = 0x1.62e42feep-1, ln2_rest = 0x1.a39ef35793c76p-33;
  const auto n = static_cast<int>(x / (ln2 + ln2_rest));
  const double r = n * ln2_rest - (x - n * ln2);
  constexpr auto coefficients = [] {
    std::array<double, 19> all{};
    double factorial = 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = 1 / factorial;
      factorial *= static_cast<double>(i + 1);
    }
    return all;
  }();
  double series = coefficients.back();
  for (std::size_t i = coefficients.size() - 1; i-- > 0;) series = coefficients[i] + series * r;
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 - n) << 52u) * series;
}

std::uint32_t visibility_weight(double distance, double sigma, std::uint32_t vote) {
  const double q = distance / sigma;
  const double x = q * q / 2;
  // Beyond this, less than a half of the vote is subtracted.
  static_assert(full_vote <= 4096);
  if (x > 9.02) return vote;
  return static_cast<std::uint32_t>(vote * (1 - exp_of_minus(x)) + 0.5);
}

std::uint32_t quality_weight(std::span<const Corner, 3> corners, const Corner& apex, const Corner* other,
                             const Energy& energy) {
  std::array<Corner, 3> facet{corners[0], corners[1], corners[2]};
  sort_by_id(facet);
  // The sphere of an infinite cell is the facet's plane.
  const double least = std::min(cosine(facet, apex), other == nullptr ? 1.0 : cosine(facet, *other));
  return static_cast<std::uint32_t>(full_vote * energy.lambda / energy.alpha * (1 - least) + 0.5);
}

double part_to_plane(const Point& from, const Point& way, const Corner& p, const Corner& q, const Corner& r) {
  const Corner *a = &p, *b = &q, *c = &r;
  if (b->id < a->id) std::swap(a, b);
  if (c->id < b->id) std::swap(b, c);
  if (b->id < a->id) std::swap(a, b);
  const Point normal = cross(minus(b->at, a->at), minus(c->at, a->at));
  return std::abs(dot(normal, minus(a->at, from)) / dot(normal, way));
}

std::uint32_t saturating(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(std::uint64_t{a} + b, cut::capacity_max));
}

}  // namespace tessera::surface

#include "src/geometry/reference/clouds.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <stdexcept>
#include <tuple>

#include "src/base/check.h"
#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {
namespace {

struct Draw {
  std::mt19937_64 rng;
  double real() { return static_cast<double>(rng() >> 11) * 0x1p-53; }
  double integer(int n) { return static_cast<double>(rng() % static_cast<std::uint64_t>(n)); }
};

Point draw_point(const std::string& kind, int d, std::size_t n, Draw& r) {
  const int side = std::max(2, static_cast<int>(std::ceil(std::pow(static_cast<double>(n) * 1.5, 1.0 / d))));
  Point p;
  if (kind == "uniform") {
    for (int i = 0; i < d; ++i) p[i] = r.real();
  } else if (kind == "lattice") {  // all cells are cospherical
    for (int i = 0; i < d; ++i) p[i] = r.integer(side);
  } else if (kind == "sphere") {  // cospherical up to rounding
    double norm = 0;
    for (int i = 0; i < d; ++i) p[i] = r.real() * 2 - 1, norm += p[i] * p[i];
    for (int i = 0; i < d; ++i) p[i] /= std::sqrt(norm);
  } else if (kind == "clusters") {  // empty tiles, and huge shared cells between clusters
    const double at = r.integer(3) * 1e6;
    for (int i = 0; i < d; ++i) p[i] = at + r.real();
  } else if (kind == "slab") {  // like terrain: flat and quantised
    for (int i = 0; i < d; ++i) p[i] = std::round(r.real() * (i == d - 1 ? 3 : 1000)) * 0.01 + 650000;
  } else if (kind == "planes") {  // many coplanar and collinear points
    for (int i = 0; i < d; ++i) p[i] = r.integer(10 * side);
    p[d - 1] = r.integer(2);
  } else if (kind == "curve") {  // has a quadratic number of cells in 3D
    const double t = r.integer(static_cast<int>(2 * n));
    p = {t, t * t, d == 3 ? t * t * t : 0};
  } else if (kind == "jitter") {  // a lattice with coordinates off by one ulp
    for (int i = 0; i < d; ++i) p[i] = std::nextafter(r.integer(side) + 100, 1e9 * (r.real() - 0.5));
  } else {  // "corners": points on a few lattice planes, where boxes meet
    for (int i = 0; i < d; ++i) p[i] = r.integer(3) * 16 + (r.real() < 0.3 ? r.integer(16) : 0);
  }
  return p;
}

bool spans(const std::vector<LocalPoint>& points, int d) {
  const Point &a = points[0].at, &b = points[1].at;
  for (std::size_t i = 2; i < points.size(); ++i) {
    const Point& c = points[i].at;
    if (d == 2 ? exact::orientation_2(a, b, c) != 0 : !exact::collinear_3(a, b, c)) {
      if (d == 2) return true;
      for (const LocalPoint& p : points) {
        if (exact::orientation_3(a, b, c, p.at) != 0) return true;
      }
      return false;
    }
  }
  return false;
}

}  // namespace

const std::vector<std::string>& cloud_kinds() {
  static const std::vector<std::string> kinds{"uniform", "lattice", "sphere", "clusters", "slab",
                                              "planes",  "curve",   "jitter", "corners"};
  return kinds;
}

std::vector<LocalPoint> make_cloud(const std::string& kind, int dimension, std::size_t n, std::uint64_t seed) {
  check(std::find(cloud_kinds().begin(), cloud_kinds().end(), kind) != cloud_kinds().end(), "unknown kind of cloud");
  Draw r{std::mt19937_64(seed)};
  constexpr int rounds_max = 1000;  // a few points of a coarse kind may not span space, a hundred of them always do
  for (int round = 0; round < rounds_max; ++round) {
    std::set<Point> seen;
    std::vector<LocalPoint> points;
    for (std::size_t tries = 0; points.size() < n && tries < 20 * n; ++tries) {
      const Point p = without_negative_zero(draw_point(kind, dimension, n, r));
      if (seen.insert(p).second) points.push_back({p, PointId{points.size()}});
    }
    if (points.size() > static_cast<std::size_t>(dimension) && spans(points, dimension)) return points;
  }
  throw std::invalid_argument("no cloud of " + std::to_string(n) + " points of the kind " + kind + " spans " +
                              std::to_string(dimension) + "-dimensional space");
}

std::vector<double> coordinates_of(const std::vector<LocalPoint>& cloud, int dimension) {
  std::vector<double> coordinates;
  for (const LocalPoint& p : cloud) {
    for (int i = 0; i < dimension; ++i) coordinates.push_back(p.at[i]);
  }
  return coordinates;
}

}  // namespace tessera

// Small clouds with the ways in which real and adversarial points are degenerate, for the tests of this folder.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "src/base/point.h"

namespace tessera {

inline const std::vector<std::string>& cloud_names() {
  static const std::vector<std::string> names{"none",      "one",        "two",       "uniform",   "lattice",
                                              "identical", "duplicates", "collinear", "diagonal",  "coplanar",
                                              "clusters",  "octaves",    "denormal",  "overflow",  "extremes",
                                              "ulp_twins", "outlier",    "exponents", "two_values"};
  return names;
}

// `n` points or fewer of the named cloud; z is 0 in 2D. No -0.
inline std::vector<Point> make_cloud(const std::string& name, int dimension, std::size_t n, unsigned seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto integer = [&](int below) { return static_cast<double>(random() % static_cast<unsigned>(below)); };
  constexpr double most = std::numeric_limits<double>::max();
  constexpr double least = std::numeric_limits<double>::denorm_min();
  if (name == "none") n = 0;
  if (name == "one") n = 1;
  if (name == "two") n = 2;
  std::vector<Point> points;
  for (std::size_t i = 0; i < n; ++i) {
    Point p{unit(random), unit(random), unit(random)};
    if (name == "lattice") p = {integer(10), integer(10), integer(10)};
    if (name == "identical") p = {3.25, -7.5, 1e-3};
    if (name == "duplicates") p = {integer(3), integer(2), integer(2)};
    if (name == "collinear") p = {integer(1000), 5, 5};
    if (name == "diagonal") p.y = p.z = p.x = integer(500);
    if (name == "coplanar") p = {integer(100), integer(100), 7};
    if (name == "clusters" && i % 2 == 1) p.x += 1e9;
    if (name == "octaves") {
      const double scale = std::ldexp(1, static_cast<int>(i % 40));
      p = {p.x * scale, p.y * scale, p.z * scale};
    }
    if (name == "denormal") p = {least * integer(50), -least * integer(50), least * integer(50)};
    if (name == "overflow") p = {(p.x - 0.5) * 1.9 * most, (p.y - 0.5) * 1.9 * most, (p.z - 0.5) * 1.9 * most};
    if (name == "extremes") p = {i % 2 ? most : -most, i % 3 ? most : -most, i % 5 ? most : 0};
    if (name == "ulp_twins" && i % 2 == 1) {
      p = points.back();
      p.x = std::nextafter(p.x, 2.0);
    }
    if (name == "outlier" && i == n / 2) p = {1e7, -1e7, 1e9};
    if (name == "exponents") {
      for (int a = 0; a < 3; ++a) p[a] = std::ldexp(random() % 2 ? 1 : -1, static_cast<int>(random() % 601) - 300);
    }
    if (name == "two_values") p = {integer(2), integer(2), i == 0 ? 1.0 : 0.0};
    if (dimension == 2) p.z = 0;
    points.push_back(without_negative_zero(p));
  }
  return points;
}

inline Bounds bounds_of(const std::vector<Point>& points) {
  Bounds bounds;
  for (const Point& p : points) bounds.add(p);
  return bounds;
}

}  // namespace tessera

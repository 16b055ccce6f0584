#include "src/input/generate/halos.h"

#include <algorithm>
#include <cmath>

#include "src/input/generate/direction.h"

namespace tessera {
namespace {

constexpr double least_particles = 20, overdensity = 200, pi = 3.14159265358979323846;
constexpr std::uint64_t one_anywhere_in = 5;

// The d-th root, by Newton's method: C libraries round their own roots. REQUIRES: 0 < v <= 1.
double root_of(double v, int d) {
  if (d == 2) return std::sqrt(v);
  double x = 1;
  for (int i = 0; i < 128; ++i) x = (2 * x + v / (x * x)) / 3;
  return x;
}

// Moves a coordinate into the cube by whole periods.
double in_cube(double x) {
  x -= std::floor(x);
  return x < 1 ? x : 0;
}

}  // namespace

Halos::Halos(std::uint64_t points, std::uint64_t seed, int dimension)
    : random_(seed),
      dimension_(dimension),
      particles_(static_cast<double>(points)),
      most_(std::max(least_particles, particles_ / 100)) {}

Point Halos::anywhere() {
  Point p;
  for (int axis = 0; axis < dimension_; ++axis) p[axis] = random_.unit();
  return p;
}

void Halos::begin_halo() {
  const double m = least_particles / (1 - random_.unit() * (1 - least_particles / most_));
  left_ = static_cast<std::uint64_t>(m);
  centre_ = anywhere();
  const double ball = dimension_ == 2 ? pi : 4 * pi / 3;
  radius_ = root_of(std::min(1.0, m / (ball * overdensity * std::max(1.0, particles_))), dimension_);
}

Point Halos::next() {
  if (made_++ % one_anywhere_in == 0) return anywhere();
  if (left_ == 0) begin_halo();
  --left_;
  const double r = radius_ * random_.unit();
  const Point towards = direction(random_, dimension_);
  Point p;
  for (int axis = 0; axis < dimension_; ++axis) p[axis] = in_cube(centre_[axis] + r * towards[axis]);
  return p;
}

}  // namespace tessera

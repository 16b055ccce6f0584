// Hilbert curve keys. They keep points together in the order of insertion, and cells in the files.
#pragma once

#include <cstdint>

#include "src/base/point.h"

namespace tessera {

// Computes the position of a point on a Hilbert curve: 21 bits an axis in 3D, 31 bits in 2D. The curve fills the cube
// that has the lower corner and the longest side of `bounds`. Points outside the cube are clamped; the order affects
// speed only. All axes have one scale, because what is near in a Delaunay triangulation is near in space, not near in
// proportion to the box. Thread-safe.
// Source of the curve: Hamilton, Compact Hilbert indices, Dalhousie CS-2006-07, section 2; its steps are tabulated
// here.
class HilbertKey {
 public:
  HilbertKey(const Bounds& bounds, int dimension);
  std::uint64_t operator()(const Point& p) const;

 private:
  Point origin_;         // bounds.lo * prescale_
  double prescale_ = 1;  // a power of two: keeps extents near 1e308 finite and denormal ones invertible
  double scale_ = 0;
  int dimension_;
};

}  // namespace tessera

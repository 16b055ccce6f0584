// Hilbert curve keys, for locality of insertion and of the written cells.
#pragma once

#include <cstdint>

#include "src/base/point.h"

namespace tessera {

// The position of p on a Hilbert curve through the cube that shares its lower corner and longest side with `bounds`:
// 21 bits an axis in 3D, 31 in 2D. Points outside are clamped; the order is only a matter of speed. One scale for all
// axes, since what is near in a Delaunay triangulation is near in space, not near in proportion to the box.
// Curve: Hamilton, Compact Hilbert indices, Dalhousie CS-2006-07, section 2, with its steps tabulated.
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

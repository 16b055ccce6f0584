// Hilbert curve keys, for locality of insertion and of the written cells.
#pragma once

#include <cstdint>

#include "src/base/point.h"

namespace tessera {

// The position of p on a Hilbert curve through `bounds`: 21 bits an axis in 3D, 31 in 2D. Points outside are clamped;
// the order is only a matter of speed.
class HilbertKey {
 public:
  HilbertKey(const Bounds& bounds, int dimension);
  std::uint64_t operator()(const Point& p) const;

 private:
  Bounds bounds_;
  Point scale_;
  int dimension_;
};

}  // namespace tessera

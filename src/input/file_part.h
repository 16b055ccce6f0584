// A part of a file of points that can be read by itself.
#pragma once

#include <cstdint>

#include "src/base/point.h"

namespace tessera {

// A node of an octree over the points: consecutive points of the file.
struct FilePart {
  std::uint64_t first = 0, points = 0;  // the number of its first point in the file
  std::uint64_t begin = 0, bytes = 0;   // the stored bytes: where they are in the file (COPC), and their number
  Bounds bounds;                        // a closed box of all its points, as the file states it
};

// Whether a point may be in both of these closed boxes.
inline bool meets(const Bounds& bounds, const Box& box) {
  for (int axis = 0; axis < 3; ++axis)
    if (bounds.hi[axis] < box.lo[axis] || bounds.lo[axis] > box.hi[axis]) return false;
  return true;
}

}  // namespace tessera

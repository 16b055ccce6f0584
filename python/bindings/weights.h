// Barycentric coordinates of points in the simplices that hold them.
#pragma once

#include <cstdint>
#include <span>

namespace tessera::python {

// out[i]: of query i (k x dimension) in simplex found[i], which holds it: dimension+1 numbers, none under 0, that add
// up to 1 but for rounding; 1 and zeros at a vertex. NaN where found[i] is -1. Also of simplices that are nearly flat,
// of any size, they are right to some 10 digits. `points`: n x dimension, `simplices`: m x (dimension+1), dimension = 2
// or 3. REQUIRES: out.size() == k*(dimension+1).
void barycentric_weights(std::span<const double> points, std::span<const std::int32_t> simplices, int dimension,
                         std::span<const double> queries, std::span<const std::int32_t> found, std::span<double> out);

}  // namespace tessera::python

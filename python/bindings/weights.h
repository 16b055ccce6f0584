// Barycentric coordinates of points in the simplices that contain them.
#pragma once

#include <cstdint>
#include <span>

namespace tessera::python {

// Writes the barycentric coordinates of query i in the simplex found[i], which contains the query, to row i of `out`:
// dimension+1 numbers, none below 0, that add up to 1 but for rounding; one 1 and zeros at a vertex. NaN if found[i] is
// -1. The numbers are right to some 10 digits, also in simplices that are nearly flat, of any size.
// Shapes: `points` n x dimension, `simplices` m x (dimension+1), `queries` k x dimension; dimension is 2 or 3.
// REQUIRES: out.size() == k*(dimension+1).
void barycentric_weights(std::span<const double> points, std::span<const std::int32_t> simplices, int dimension,
                         std::span<const double> queries, std::span<const std::int32_t> found, std::span<double> out);

}  // namespace tessera::python

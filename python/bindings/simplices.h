// Arrays that SciPy's Delaunay derives from its simplices, computed in the same way.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tessera::python {

// Computes for every simplex the affine map from x to the first d barycentric coordinates c: T c = x - r, where r is
// the last vertex. out[s] is (d+1) x d: the inverse of T, then r. It is NaN for simplices that are degenerate or nearly
// so: when the reciprocal condition number of T (1-norm) is below 1000 * 2^-52, which is SciPy's limit.
// `points`: n x d, `simplices`: m x (d+1), d = 2 or 3. REQUIRES: out.size() == m * (d+1) * d.
void barycentric_transforms(std::span<const double> points, std::span<const std::int32_t> simplices, int dimension,
                            std::span<double> out);

// The neighbours of vertex v are indices[starts[v]] to indices[starts[v+1]], ascending; starts has n+1 entries.
struct VertexNeighbors {
  std::vector<std::int32_t> starts, indices;
};

// Returns the neighbours of all vertices. `simplices`: m rows of `corners` indices below `vertices`. Throws
// std::length_error if there are 2^31 neighbours or more, because SciPy's arrays are int32.
VertexNeighbors vertex_neighbors(std::span<const std::int32_t> simplices, int corners, std::size_t vertices);

}  // namespace tessera::python

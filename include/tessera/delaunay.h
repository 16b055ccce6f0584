// The Delaunay triangulation of points in memory, in one piece, for clouds that one machine holds easily.
// tessera/triangulation.h is for larger clouds.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <utility>

#include "tessera/failure.h"
#include "tessera/visibility.h"

namespace tessera {

// A Delaunay triangulation in 2D or 3D. The result is exact. For points in general position it is the one Delaunay
// triangulation; for cospherical points it is always the same one, which the symbolic perturbation of docs/design.md
// chooses. Const functions may be called from several threads at once. Spans are valid as long as the Delaunay lives.
class TESSERA_PUBLIC Delaunay {
 public:
  // Copies `coordinates` and triangulates them. Shape: n x dimension, row after row; dimension is 2 or 3.
  // Failure: usage for another dimension, or a length that the dimension does not divide; bad_input for coordinates
  // that are not finite, and for points that all lie on one line (2D) or plane (3D); memory for more than 2^29 cells;
  // interrupted when `stop` is requested.
  Delaunay(std::span<const double> coordinates, int dimension, std::stop_token stop = {});
  // Rebuilds a Delaunay from the arrays that another one returned, without triangulating again. REQUIRES: the arrays
  // are unchanged. Failure: usage for lengths, indices or coordinates that no Delaunay returns.
  static Delaunay restore(std::span<const double> points, int dimension, std::span<const std::int32_t> simplices,
                          std::span<const std::int32_t> neighbors,
                          std::span<const std::pair<std::int32_t, std::int32_t>> duplicates);
  ~Delaunay();
  Delaunay(Delaunay&&) noexcept;
  Delaunay& operator=(Delaunay&&) noexcept;

  int dimension() const;
  // The coordinates as they were given. Shape: n x dimension.
  std::span<const double> points() const;
  // The vertices of each of the m simplices, as indices of points. Shape: m x (dimension+1). Simplices are positively
  // oriented: det(p1-p0, ..., pd-p0) > 0.
  std::span<const std::int32_t> simplices() const;
  // For each vertex of a simplex, the simplex across the opposite facet; -1 if the facet is on the hull. Shape:
  // m x (dimension+1).
  std::span<const std::int32_t> neighbors() const;
  // Pairs (duplicate, kept) of indices of points with equal coordinates, in ascending order. The kept point is the
  // first of its equals, and is the vertex.
  std::span<const std::pair<std::int32_t, std::int32_t>> duplicates() const;

  // Writes, for each of the k query points, a simplex that contains the point to `out`. A simplex contains its
  // boundary; the test is exact. Writes -1 for points outside the convex hull and for coordinates that are not finite.
  // Shape of `queries`: k x dimension. Failure: usage if out.size() is not k.
  void find_simplex(std::span<const double> queries, std::span<std::int32_t> out) const;

 private:
  struct Impl;
  explicit Delaunay(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera

// The Delaunay triangulation of points in memory, in one piece: for clouds that one machine holds easily.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <utility>

#include "tessera/failure.h"
#include "tessera/visibility.h"

namespace tessera {

// Exact: of points in general position, the one Delaunay triangulation; of cospherical ones, the one that the symbolic
// perturbation of docs/design.md picks, always the same.
class TESSERA_PUBLIC Delaunay {
 public:
  // `coordinates`: n x dimension, row after row; dimension 2 or 3. They are copied. Failure: usage for a dimension or a
  // length that does not fit, bad_input for coordinates that are not finite and for points on one line or plane,
  // memory for more cells than 2^29, interrupted.
  Delaunay(std::span<const double> coordinates, int dimension, std::stop_token stop = {});
  // One that was there, of what its functions below gave, without triangulating again. REQUIRES that they are. Failure:
  // usage for lengths, indices and coordinates that cannot be.
  static Delaunay restore(std::span<const double> points, int dimension, std::span<const std::int32_t> simplices,
                          std::span<const std::int32_t> neighbors,
                          std::span<const std::pair<std::int32_t, std::int32_t>> duplicates);
  ~Delaunay();
  Delaunay(Delaunay&&) noexcept;
  Delaunay& operator=(Delaunay&&) noexcept;

  int dimension() const;
  // n x dimension, as given.
  std::span<const double> points() const;
  // m x (dimension+1) indices of points; positively oriented: det(p1-p0, ..., pd-p0) > 0.
  std::span<const std::int32_t> simplices() const;
  // m x (dimension+1): the simplex across the facet opposite each vertex, -1 outside.
  std::span<const std::int32_t> neighbors() const;
  // (duplicate, kept) indices of equal points, ascending: the first of them is the vertex.
  std::span<const std::pair<std::int32_t, std::int32_t>> duplicates() const;

  // For each of the k query points (k x dimension) a simplex that holds it, its boundary included (exactly, whatever
  // the rounding), or -1 outside the convex hull and for coordinates that are not finite. Safe to call at once from
  // several threads. REQUIRES: out.size() == k.
  void find_simplex(std::span<const double> queries, std::span<std::int32_t> out) const;

 private:
  struct Impl;
  explicit Delaunay(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera

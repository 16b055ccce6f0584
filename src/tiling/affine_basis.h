// Finds the first points of a stream that span space, and the lexicographically least point.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/base/flat_codec.h"
#include "src/base/image.h"
#include "src/base/point.h"

namespace tessera {

// Keeps the first point, the first that differs from it, the first off their line, and (3D) the first off their plane.
// Points arrive by ascending id. No equal point came before a point that extends the span, so its id is the lowest with
// these coordinates. The same holds for the least point. The tests are exact. Once the span is complete a point costs
// one comparison.
//
// With periods, only the axes without one are spanned: the images of a point span the others. So the points are kept
// that would be kept if the other coordinates were 0.
class AffineBasis {
 public:
  explicit AffineBasis(int dimension, const Period& period = {});

  void add(std::span<const LocalPoint> points);
  // Adds the points that follow, as another finder has seen them; `first_id` is to be added to their ids. The kept
  // points of `next` are enough: the first following points that extend the span of this finder also extended the span
  // of `next`.
  void add(const AffineBasis& next, std::uint64_t first_id);
  void write(FlatWriter& to) const;
  // Returns false when the bytes are not what write() makes.
  bool read(FlatReader& from);

  // -1: no points; 0: all equal; 1: all on a line; 2: all in a plane; 3. With periods, of the axes without one.
  int rank() const { return static_cast<int>(span_.size()) - 1; }
  bool complete() const { return rank() == static_cast<int>(axes_.size()); }
  const std::vector<LocalPoint>& span() const { return span_; }
  const LocalPoint& least() const { return least_; }  // REQUIRES: rank() >= 0

 private:
  bool extends(const Point& p) const;
  // The coordinates along the spanned axes.
  Point spanned(const Point& p) const;

  int dimension_;
  std::vector<int> axes_;  // that are spanned
  std::vector<LocalPoint> span_;
  LocalPoint least_;
};

// Returns why `points` points of rank `rank` have no triangulation, as the end of a sentence. REQUIRES: rank is less
// than the number of axes without a period.
std::string why_flat(std::uint64_t points, int rank, int dimension, const Period& period = {});

}  // namespace tessera

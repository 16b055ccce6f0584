// The first points of a stream that span the space, and the lexicographically least point.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/base/flat_codec.h"
#include "src/base/point.h"

namespace tessera {

// Keeps the first point, the first that differs from it, the first off their line, and (3D) the first off their plane.
// Points arrive by ascending id, and a point that extends the span has had no equal before it: its id is the lowest of
// its coordinates. The same holds for the least point. Exact; once the span is complete a point costs one comparison.
class SpanFinder {
 public:
  explicit SpanFinder(int dimension) : dimension_(dimension) {}

  void add(std::span<const LocalPoint> points);
  // What the points that follow have shown, whose ids are `first_id` more than they say: of those that extend the span
  // of these points, the first of each rank extended their own.
  void add(const SpanFinder& next, std::uint64_t first_id);
  void write(FlatWriter& to) const;
  // False when it is not what write() gives.
  bool read(FlatReader& from);

  // -1: no points; 0: all equal; 1: all on a line; 2: all in a plane; 3.
  int rank() const { return static_cast<int>(span_.size()) - 1; }
  bool complete() const { return rank() == dimension_; }
  const std::vector<LocalPoint>& span() const { return span_; }
  const LocalPoint& least() const { return least_; }  // REQUIRES: rank() >= 0

 private:
  bool extends(const Point& p) const;

  int dimension_;
  std::vector<LocalPoint> span_;
  LocalPoint least_;
};

// Why `points` points of rank() `rank` have no triangulation, as the end of a sentence. REQUIRES: rank < dimension.
std::string why_flat(std::uint64_t points, int rank, int dimension);

}  // namespace tessera

// Corners that go into sides of cells, where rounding has made a cell invalid.
//
// A cell may be so thin at a place that rounding puts one of its corners on one of its sides, or beyond it. Then the
// corner goes into the side, as snap rounding does (Hobby, Practical segment intersection with finite precision output,
// Computational Geometry 13 (1999)). The cell on the other side of this side gets the corner, too, so both still share
// their sides to the bit. The cell itself loses what has no width any more.
#pragma once

#include <cstddef>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "src/base/point.h"
#include "src/result/voronoi/cell_shape.h"

namespace tessera::voronoi {

// `corner` goes between the corners a and b; a is the lesser.
struct Insertion {
  Point a, b, corner;
};

// An insertion that brings a part closer to being valid; nothing when there is none. REQUIRES: the part is not valid.
std::optional<Insertion> find_insertion(std::span<const Ring> part);

// Makes the corner a corner of all rings with the side. True when there was one.
bool insert(CellShape& shape, std::span<const Insertion> sorted);
// Cuts rings at corners that they visit twice, and leaves out rings without width.
void clean(CellShape& shape);

class Repairs {
 public:
  // Finds insertions that make the part valid, and keeps them. False when there are none. Thread-safe.
  bool repair(const std::vector<Ring>& part);
  // Call this when all are found, before apply().
  void finish();
  bool empty() const { return all_.empty(); }
  // Applies the insertions. True when the shape was changed; its parts may then be invalid.
  bool apply(CellShape& shape) const;

 private:
  std::mutex mutex_;
  std::vector<Insertion> all_;
};

}  // namespace tessera::voronoi

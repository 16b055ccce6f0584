// A sample of the cells as a k-d tree. A walk that is blocked by a hole of frozen cells begins again at a cell of the
// sample. The sample may be out of date: a slot may have become free, or hold a cell elsewhere. That costs only time.
#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "src/geometry/kernel/flat/cells.h"
#include "src/geometry/kernel/flat/points.h"

namespace tessera::flat {

template <int dimension>
class NearbyCells {
 public:
  // A cell of the sample, with the coordinates of one of its vertices.
  struct CellSample {
    Point at;
    Index slot;
  };

  void set(std::vector<CellSample> samples) {
    samples_ = std::move(samples);
    order(0, samples_.size(), 0);
  }
  void clear() { release(samples_); }
  bool empty() const { return samples_.empty(); }
  // The slots of the samples nearest to p, the nearest first. At most `count` slots are returned; usable(slot) is true
  // for each.
  static constexpr std::size_t count = 8;
  template <class Usable>
  std::vector<Index> nearest(const Point& p, const Usable& usable) const {
    Found found;
    search(p, usable, 0, samples_.size(), 0, found);
    return {found.slots, found.slots + found.size};
  }
  std::size_t memory() const { return samples_.capacity() * sizeof(CellSample); }

 private:
  struct Found {
    double distances[count];  // ascending
    Index slots[count];
    std::size_t size = 0;

    double limit() const { return size < count ? std::numeric_limits<double>::infinity() : distances[count - 1]; }
    void add(double distance, Index slot) {
      std::size_t i = size < count ? size++ : count - 1;
      for (; i > 0 && distances[i - 1] > distance; --i) distances[i] = distances[i - 1], slots[i] = slots[i - 1];
      distances[i] = distance, slots[i] = slot;
    }
  };

  static double coordinate(const Point& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

  // Puts the median of [begin, end) by one axis in the middle, and orders both halves by the next axis.
  void order(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return samples_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [axis](const CellSample& a, const CellSample& b) {
      return coordinate(a.at, axis) < coordinate(b.at, axis);
    });
    const int next = (axis + 1) % dimension;
    order(begin, middle, next);
    order(middle + 1, end, next);
  }

  template <class Usable>
  void search(const Point& p, const Usable& usable, std::size_t begin, std::size_t end, int axis, Found& found) const {
    if (begin >= end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const CellSample& sample = samples_[middle];
    const double distance = squared_distance<dimension>(p, sample.at);
    if (distance < found.limit() && usable(sample.slot)) found.add(distance, sample.slot);
    const double beyond = coordinate(p, axis) - coordinate(sample.at, axis);
    const int next = (axis + 1) % dimension;
    for (const bool near : {true, false}) {
      if (!near && !(beyond * beyond < found.limit())) return;
      if ((beyond < 0) == near) {
        search(p, usable, begin, middle, next, found);
      } else {
        search(p, usable, middle + 1, end, next, found);
      }
    }
  }

  std::vector<CellSample> samples_;
};

}  // namespace tessera::flat

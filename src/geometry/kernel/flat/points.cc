#include "src/geometry/kernel/flat/points.h"

#include <algorithm>

namespace tessera::flat {
namespace {

// The pointer p with p[1] the first point, because vertices are numbered from 1.
const Point* before(const Point* first) { return first ? first - 1 : nullptr; }

}  // namespace

Vertex Points::number_of(std::span<const Point> points) const {
  if (points.size() > most_) throw KernelFull();
  return static_cast<Vertex>(points.size());
}

void Points::borrow(std::span<const Point> points) {
  size_ = borrowed_ = number_of(points);
  own_.clear();
  low_ = high_ = before(points.data());
}

void Points::copy(std::span<const Point> points) {
  size_ = borrowed_ = number_of(points);
  own_.clear();
  own_.resize(points.size());
  std::copy(points.begin(), points.end(), own_.data());
  low_ = high_ = before(own_.data());
}

void Points::copy(const Points& other) {
  own_.clear();
  own_.resize(other.size_);
  for (Vertex v = 1; v <= other.size_; ++v) own_[v - 1] = other[v];
  size_ = borrowed_ = other.size_;
  low_ = high_ = before(own_.data());
}

void Points::own() {
  if (own_.size() < size_) copy({low_ + 1, size_});
}

Vertex Points::add(Point p) {
  if (size_ >= most_) throw KernelFull();
  const bool all_own = own_.size() == size_;
  own_.push_back(p);
  ++size_;
  if (all_own) {
    low_ = high_ = before(own_.data());
    borrowed_ = size_;
  } else {
    high_ = before(own_.data()) - borrowed_;
  }
  return size_;
}

}  // namespace tessera::flat

// The points of a flat kernel by vertex number, from 1. The first points may be borrowed from the caller.
#pragma once

#include <span>

#include "src/geometry/kernel/flat/memory.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera::flat {

class Points {
 public:
  // This constructor's limit holds for all functions: they throw KernelFull for more than `most` points.
  explicit Points(Vertex most) : most_(most) {}
  const Point& operator[](Vertex v) const { return (v <= borrowed_ ? low_ : high_)[v]; }
  // first()[v] is vertex v when in_one_piece(). Inner loops use it to save a branch.
  const Point* first() const { return low_; }
  bool in_one_piece() const { return size_ == borrowed_; }
  Vertex size() const { return size_; }
  Vertex most() const { return most_; }
  void borrow(std::span<const Point> points);
  void copy(std::span<const Point> points);
  void copy(const Points& other);
  // Copies borrowed points, so that all points stay in one piece when more are added.
  void own();
  Vertex add(Point p);
  std::size_t memory() const { return own_.bytes(); }

 private:
  Vertex number_of(std::span<const Point> points) const;

  const Point* low_ = nullptr;   // low_[v] is vertex v for v in 1..borrowed_
  const Point* high_ = nullptr;  // high_[v] is vertex v for larger v
  Vertex borrowed_ = 0, size_ = 0, most_;
  Array<Point> own_;
};

template <int dimension>
bool same_place(const Point& p, const Point& q) {
  return p.x == q.x && p.y == q.y && (dimension == 2 || p.z == q.z);
}

template <int dimension>
double squared_distance(const Point& p, const Point& q) {
  const double x = p.x - q.x, y = p.y - q.y, z = dimension == 2 ? 0 : p.z - q.z;
  return x * x + y * y + z * z;
}

}  // namespace tessera::flat

// Triangulates points that come in groups.
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <vector>

#include "src/base/duplicate_policy.h"
#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

// A Delaunay triangulation to which groups of points are added. Points with equal coordinates are one vertex, whose id
// is that of the kept point.
class GrowingTriangulation {
 public:
  explicit GrowingTriangulation(int dimension, DuplicatePolicy keep = DuplicatePolicy::first);

  // Adds points. `heights` has the heights of the points, in their order; it is empty unless equal points are kept by
  // height. Throws Stopped soon after `stop` is requested, and KernelFull when there are too many points. After an
  // exception the object can only be destroyed.
  void add(std::vector<LocalPoint> points, std::vector<double> heights, const std::stop_token& stop);

  int dimension() const { return dimension_; }
  int rank() const { return kernel_->dimension(); }  // that the points span; below dimension() there are no cells
  std::size_t points() const { return points_; }     // that were added, equal ones included
  CellList cells() const { return kernel_->cells(); }
  Vertex vertices() const { return kernel_->vertices(); }
  Point point(Vertex v) const { return kernel_->point(v); }
  PointId id(Vertex v) const { return ids_[v - 1]; }

 private:
  // Distinct points, in the kernel's order of insertion.
  struct Ordered {
    std::vector<Point> points;
    std::vector<PointId> ids;
    std::vector<double> heights;  // empty unless points are kept by height
  };
  Ordered ordered(std::vector<LocalPoint> points, std::vector<double> heights) const;
  void build(std::vector<LocalPoint> points, std::vector<double> heights, const std::stop_token& stop);

  int dimension_;
  DuplicatePolicy keep_;
  std::unique_ptr<Kernel> kernel_;
  std::vector<PointId> ids_;     // by vertex, from 1 on
  std::vector<double> heights_;  // likewise; empty unless points are kept by height
  std::size_t points_ = 0;
};

}  // namespace tessera

// The triangulation of points that come in groups.
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <vector>

#include "src/base/duplicate_policy.h"
#include "src/base/point.h"
#include "src/geometry/kernel/kernel.h"

namespace tessera {

// Equal points are one vertex, that of the one among them that is kept.
class GrowingTriangulation {
 public:
  explicit GrowingTriangulation(int dimension, DuplicatePolicy keep = DuplicatePolicy::first);

  // Throws Stopped soon after `stop` is requested, KernelFull when there are too many points: it can only be destroyed
  // then.
  // `heights`: of the points, in their order; empty when they are not kept by height.
  void add(std::vector<LocalPoint> points, std::vector<double> heights, const std::stop_token& stop);

  int dimension() const { return dimension_; }
  int rank() const { return kernel_->dimension(); }  // of the points: below dimension() there are no cells
  std::size_t points() const { return points_; }     // that were added, equal ones counted
  CellList cells() const { return kernel_->cells(); }
  Vertex vertices() const { return kernel_->vertices(); }
  Point point(Vertex v) const { return kernel_->point(v); }
  PointId id(Vertex v) const { return ids_[v - 1]; }

 private:
  // Distinct, in the order for the kernel.
  struct Ordered {
    std::vector<Point> points;
    std::vector<PointId> ids;
    std::vector<double> heights;  // none when they are not kept by height
  };
  Ordered ordered(std::vector<LocalPoint> points, std::vector<double> heights) const;
  void build(std::vector<LocalPoint> points, std::vector<double> heights, const std::stop_token& stop);

  int dimension_;
  DuplicatePolicy keep_;
  std::unique_ptr<Kernel> kernel_;
  std::vector<PointId> ids_;     // by vertex, from 1 on
  std::vector<double> heights_;  // likewise; none when they are not kept by height
  std::size_t points_ = 0;
};

}  // namespace tessera

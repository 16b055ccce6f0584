#include "src/region/growing.h"

#include <algorithm>
#include <utility>

#include "src/base/stopped.h"
#include "src/kernel/brio.h"
#include "src/tiling/routed_run.h"

namespace tessera {

GrowingTriangulation::GrowingTriangulation(int dimension) : dimension_(dimension), kernel_(make_kernel(dimension)) {}

void GrowingTriangulation::build(std::vector<LocalPoint> points, const std::stop_token& stop) {
  LoadedTile ordered = order_points(points, dimension_);
  std::vector<LocalPoint>().swap(points);
  kernel_->build(ordered.points, KeepPoints::copied, stop);
  ids_ = std::move(ordered.ids);
}

void GrowingTriangulation::add(std::vector<LocalPoint> points, const std::stop_token& stop) {
  points_ += points.size();
  // Insertion one by one takes longer than building, which knows that nobody asks for the new vertex's neighbours.
  if (rank() < dimension_ || points.size() > ids_.size()) {
    for (Vertex v = 1; v <= ids_.size(); ++v) points.push_back({point(v), id(v)});
    return build(std::move(points), stop);
  }
  const LoadedTile ordered = order_points(points, dimension_);
  std::vector<LocalPoint>().swap(points);
  StopCheck check(stop, 4096);
  std::vector<Vertex> around;
  for_each_in_brio_order(ordered.points.size(), [&](std::size_t i) {
    check.step();
    const Insertion made = kernel_->insert(ordered.points[i], true, InsertMode::always, around);
    if (made.inserted) {
      ids_.push_back(ordered.ids[i]);
    } else {
      PointId& kept = ids_[made.vertex - 1];
      kept = std::min(kept, ordered.ids[i]);
    }
  });
}

}  // namespace tessera

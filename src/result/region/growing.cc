#include "src/result/region/growing.h"

#include <algorithm>
#include <span>
#include <utility>

#include "src/base/stopped.h"
#include "src/geometry/kernel/brio.h"
#include "src/tiling/kept_points.h"

namespace tessera {

GrowingTriangulation::GrowingTriangulation(int dimension, DuplicatePolicy keep)
    : dimension_(dimension), keep_(keep), kernel_(make_kernel(dimension)) {}

GrowingTriangulation::Ordered GrowingTriangulation::ordered(std::vector<LocalPoint> points,
                                                            std::vector<double> heights) const {
  LoadedTile loaded = order_points(points, dimension_);
  std::vector<std::pair<PointId, double>> by_id;
  if (!heights.empty()) {
    by_id.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) by_id.emplace_back(points[i].id, heights[i]);
    std::sort(by_id.begin(), by_id.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  }
  std::vector<LocalPoint>().swap(points);
  const auto heights_of = [&](std::span<const PointId> ids) -> Result<std::vector<double>> {
    std::vector<double> found;
    found.reserve(ids.size());
    for (const PointId id : ids)
      found.push_back(std::lower_bound(by_id.begin(), by_id.end(), id, [](const auto& a, PointId b) {
                        return a.first < b;
                      })->second);
    return found;
  };
  const HeightsOf known = by_id.empty() ? HeightsOf() : heights_of;
  choose_kept(keep_, known, loaded).value();  // reports no error, because nothing is read
  Ordered made{std::move(loaded.points), std::move(loaded.ids), {}};
  if (known) made.heights = heights_of(made.ids).value();
  return made;
}

void GrowingTriangulation::build(std::vector<LocalPoint> points, std::vector<double> heights,
                                 const std::stop_token& stop) {
  Ordered all = ordered(std::move(points), std::move(heights));
  kernel_->build(all.points, KeepPoints::copied, stop);
  ids_ = std::move(all.ids);
  heights_ = std::move(all.heights);
}

void GrowingTriangulation::add(std::vector<LocalPoint> points, std::vector<double> heights,
                               const std::stop_token& stop) {
  points_ += points.size();
  // Building anew is faster than inserting many points one by one, because building need not know the neighbours of new
  // vertices.
  if (rank() < dimension_ || points.size() > ids_.size()) {
    for (Vertex v = 1; v <= ids_.size(); ++v) points.push_back({point(v), id(v)});
    heights.insert(heights.end(), heights_.begin(), heights_.end());
    return build(std::move(points), std::move(heights), stop);
  }
  const Ordered more = ordered(std::move(points), std::move(heights));
  StopCheck check(stop, 4096);
  std::vector<Vertex> around;
  for_each_in_brio_order(more.points.size(), [&](std::size_t i) {
    check.step();
    const Insertion made = kernel_->insert(more.points[i], true, InsertMode::always, around);
    const double height = more.heights.empty() ? 0 : more.heights[i];
    if (made.inserted) {
      ids_.push_back(more.ids[i]);
      if (!more.heights.empty()) heights_.push_back(height);
      return;
    }
    const std::size_t v = made.vertex - 1;
    if (!is_kept_before(keep_, {more.ids[i], height}, {ids_[v], heights_.empty() ? 0 : heights_[v]})) return;
    ids_[v] = more.ids[i];
    if (!heights_.empty()) heights_[v] = height;
  });
}

}  // namespace tessera

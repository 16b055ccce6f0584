#include "src/tiling/affine_basis.h"

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {

void AffineBasis::add(std::span<const LocalPoint> points) {
  if (points.empty()) return;
  if (span_.empty()) {
    span_.push_back(points[0]);
    least_ = points[0];
  }
  for (const LocalPoint& p : points) {
    if (p.at.x <= least_.at.x && p.at < least_.at) least_ = p;
  }
  for (std::size_t i = 0; i < points.size() && !complete(); ++i) {
    if (extends(points[i].at)) span_.push_back(points[i]);
  }
}

void AffineBasis::add(const AffineBasis& next, std::uint64_t first_id) {
  std::vector<LocalPoint> points = next.span_;
  if (!points.empty()) points.push_back(next.least_);
  for (LocalPoint& p : points) p.id.value += first_id;
  add(points);
}

void AffineBasis::write(FlatWriter& to) const {
  to.list(span_);
  to.value(least_);
}

bool AffineBasis::read(FlatReader& from) {
  return from.list(span_) && span_.size() <= static_cast<std::size_t>(dimension_) + 1 && from.value(least_);
}

bool AffineBasis::extends(const Point& p) const {
  // A shortcut: points that agree with the whole span on enough axes lie in its affine hull. The exact predicates would
  // say the same at a hundred times the cost. So a flat raster of 10^8 points is refused in seconds.
  int agree = 0;
  for (int a = 0; a < dimension_; ++a) {
    bool same = true;
    for (const LocalPoint& q : span_) same = same && q.at[a] == p[a];
    agree += same;
  }
  if (dimension_ - agree <= rank()) return false;
  const Point& a = span_[0].at;
  switch (rank()) {
    case 0:
      return true;
    case 1:
      return dimension_ == 2 ? exact::orientation_2(a, span_[1].at, p) != 0 : !exact::collinear_3(a, span_[1].at, p);
    default:
      return exact::orientation_3(a, span_[1].at, span_[2].at, p) != 0;
  }
}

std::string why_flat(std::uint64_t points, int rank, int dimension) {
  const std::string n = std::to_string(points), d = std::to_string(dimension);
  if (points == 0) return "there are no points";
  if (points <= static_cast<std::uint64_t>(dimension)) {
    return "there " + std::string(points == 1 ? "is 1 point" : "are " + n + " points") + "; a " + d +
           "D triangulation needs at least " + std::to_string(dimension + 1);
  }
  if (rank == 0) return "all " + n + " points are identical";
  if (rank == 1) return "all " + n + " points lie on one line; a " + d + "D triangulation needs points off it";
  return "all " + n + " points lie in one plane; a 3D triangulation needs points off it";
}

}  // namespace tessera

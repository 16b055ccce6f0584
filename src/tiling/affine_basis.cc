#include "src/tiling/affine_basis.h"

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {

AffineBasis::AffineBasis(int dimension, const Period& period) : dimension_(dimension) {
  for (int axis = 0; axis < dimension; ++axis) {
    if (!period.along(axis)) axes_.push_back(axis);
  }
}

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

Point AffineBasis::spanned(const Point& p) const {
  Point out;
  for (std::size_t i = 0; i < axes_.size(); ++i) out[static_cast<int>(i)] = p[axes_[i]];
  return out;
}

bool AffineBasis::extends(const Point& point) const {
  const Point p = spanned(point);
  const auto axes = static_cast<int>(axes_.size());
  // A shortcut: points that agree with the whole span on enough axes lie in its affine hull. The exact predicates would
  // say the same at a hundred times the cost. So a flat raster of 10^8 points is refused in seconds.
  int agree = 0;
  for (const int axis : axes_) {
    bool same = true;
    for (const LocalPoint& q : span_) same = same && q.at[axis] == point[axis];
    agree += same;
  }
  if (axes - agree <= rank()) return false;
  const auto kept = [&](std::size_t i) { return spanned(span_[i].at); };
  switch (rank()) {
    case 0:
      return true;
    case 1:
      return axes == 2 ? exact::orientation_2(kept(0), kept(1), p) != 0 : !exact::collinear_3(kept(0), kept(1), p);
    default:
      return exact::orientation_3(kept(0), kept(1), kept(2), p) != 0;
  }
}

namespace {

// REQUIRES: an axis has a period, and another has none.
std::string why_flat_along(std::uint64_t points, int rank, int dimension, const Period& period) {
  std::string axes;
  for (int axis = 0; axis < dimension; ++axis) {
    if (!period.along(axis)) axes += (axes.empty() ? "" : " and ") + std::string(1, "xyz"[axis]);
  }
  if (points == 1) return "a single point does not span " + axes + ", along which there is no period";
  const std::string what = "the " + std::to_string(points) + " points ";
  if (rank == 0) return what + "have the same " + axes + ", along which there is no period";
  return what + "lie on one line of " + axes + ", along which there is no period";
}

}  // namespace

std::string why_flat(std::uint64_t points, int rank, int dimension, const Period& period) {
  const std::string n = std::to_string(points), d = std::to_string(dimension);
  if (points == 0) return "there are no points";
  if (period.any()) return why_flat_along(points, rank, dimension, period);
  if (points <= static_cast<std::uint64_t>(dimension)) {
    return "there " + std::string(points == 1 ? "is 1 point" : "are " + n + " points") + "; a " + d +
           "D triangulation needs at least " + std::to_string(dimension + 1);
  }
  if (rank == 0) return "all " + n + " points are identical";
  if (rank == 1) return "all " + n + " points lie on one line; a " + d + "D triangulation needs points off it";
  return "all " + n + " points lie in one plane; a 3D triangulation needs points off it";
}

}  // namespace tessera

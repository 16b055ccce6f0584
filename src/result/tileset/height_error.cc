#include <algorithm>
#include <cmath>
#include <limits>

#include "src/result/tileset/surface.h"

namespace tessera::tileset {
namespace {

// Buckets in a grid over the plane, each with the triangles whose boxes meet it.
class Buckets {
 public:
  explicit Buckets(const Surface& surface) : surface_(surface), bounds_(surface.bounds()) {
    side_ = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(surface.triangles()) / 2)), 1, 128);
    first_.assign(static_cast<std::size_t>(side_ * side_) + 1, 0);
    for_each_place([&](std::size_t bucket, std::uint32_t) { ++first_[bucket + 1]; });
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    triangles_.resize(first_.back());
    auto next = first_;
    for_each_place([&](std::size_t bucket, std::uint32_t triangle) { triangles_[next[bucket]++] = triangle; });
  }

  std::span<const std::uint32_t> at(const Point& p) const {
    const std::size_t bucket = static_cast<std::size_t>(place(p, 1) * side_ + place(p, 0));
    return std::span(triangles_).subspan(first_[bucket], first_[bucket + 1] - first_[bucket]);
  }

 private:
  int place(const Point& p, int axis) const {
    const double length = bounds_.hi[axis] - bounds_.lo[axis];
    if (!(length > 0)) return 0;
    return std::clamp(static_cast<int>((p[axis] - bounds_.lo[axis]) / length * side_), 0, side_ - 1);
  }
  template <class Visit>
  void for_each_place(const Visit& visit) const {
    for (std::uint32_t t = 0; t < surface_.triangles(); ++t) {
      Bounds box;
      for (std::size_t k = 0; k < 3; ++k) box.add(surface_.vertices[surface_.corners[3 * std::size_t{t} + k]].at);
      for (int y = place(box.lo, 1); y <= place(box.hi, 1); ++y)
        for (int x = place(box.lo, 0); x <= place(box.hi, 0); ++x) visit(static_cast<std::size_t>(y * side_ + x), t);
    }
  }

  const Surface& surface_;
  Bounds bounds_;
  int side_ = 1;
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> triangles_;
};

double twice_area(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The squared distance in height; where p is beside the triangle, the squared distance to the nearest corner.
double square_distance(const Point& p, const Point& a, const Point& b, const Point& c) {
  const double wa = twice_area(p, b, c), wb = twice_area(a, p, c), wc = twice_area(a, b, p), all = wa + wb + wc;
  const double slack = 1e-9 * std::abs(all);
  const bool inside =
      all > 0 ? wa >= -slack && wb >= -slack && wc >= -slack : all < 0 && wa <= slack && wb <= slack && wc <= slack;
  if (inside) {
    const double height = p.z - (wa * a.z + wb * b.z + wc * c.z) / all;
    return height * height;
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (const Point* corner : {&a, &b, &c}) {
    const double x = p.x - corner->x, y = p.y - corner->y, z = p.z - corner->z;
    nearest = std::min(nearest, x * x + y * y + z * z);
  }
  return nearest;
}

}  // namespace

double height_error(const Surface& fine, const Surface& coarse) {
  if (fine.vertices.empty() || coarse.triangles() == 0) return 0;
  const Buckets buckets(coarse);
  const Bounds box = coarse.bounds();
  const double farthest = std::hypot(box.hi.x - box.lo.x, box.hi.y - box.lo.y, box.hi.z - box.lo.z);
  double sum = 0;
  for (const SurfaceVertex& v : fine.vertices) {
    double nearest = farthest * farthest;
    for (const std::uint32_t t : buckets.at(v.at)) {
      const std::uint32_t* corner = &coarse.corners[3 * std::size_t{t}];
      nearest = std::min(nearest, square_distance(v.at, coarse.vertices[corner[0]].at, coarse.vertices[corner[1]].at,
                                                  coarse.vertices[corner[2]].at));
    }
    sum += nearest;
  }
  return std::sqrt(sum / static_cast<double>(fine.vertices.size()));
}

}  // namespace tessera::tileset

#include "src/result/query/hull.h"

#include <algorithm>
#include <utility>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::query {
namespace {

bool before(const Point& a, const Point& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

// Andrew's monotone chain.
void make_hull(std::vector<Point>& points) {
  std::sort(points.begin(), points.end(), before);
  points.erase(std::unique(points.begin(), points.end(),
                           [](const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; }),
               points.end());
  if (points.size() < 3) return;
  std::vector<Point> hull;
  const auto turn = [&](const Point& p, std::size_t least) {
    while (hull.size() >= least + 2 && exact::orientation_2(hull[hull.size() - 2], hull.back(), p) <= 0)
      hull.pop_back();
    hull.push_back(p);
  };
  for (const Point& p : points) turn(p, 0);
  const std::size_t below = hull.size() - 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) turn(points[i], below);
  hull.pop_back();
  points = std::move(hull);
}

// True if the closed hull contains the box.
bool covers(const std::vector<Point>& hull, const Bounds& box) {
  if (hull.size() < 3) return false;
  for (const Point& corner : {Point{box.lo.x, box.lo.y, 0}, Point{box.hi.x, box.lo.y, 0}, Point{box.hi.x, box.hi.y, 0},
                              Point{box.lo.x, box.hi.y, 0}})
    for (std::size_t i = 0; i < hull.size(); ++i)
      if (exact::orientation_2(hull[i], hull[(i + 1) % hull.size()], corner) < 0) return false;
  return true;
}

}  // namespace

Bounds box_of(const Manifest& manifest, TileId tile) {
  Bounds box = manifest.bounds;
  if (tile.value >= manifest.boxes.size()) return box;
  const Box& part = manifest.boxes[tile.value];
  for (int axis = 0; axis < manifest.dimension; ++axis) {
    box.lo[axis] = std::max(box.lo[axis], part.lo[axis]);
    box.hi[axis] = std::min(box.hi[axis], part.hi[axis]);
  }
  return box;
}

Result<std::vector<Point>> hull_of(const TileSource& source, const std::stop_token& stop) {
  const Manifest& manifest = source.manifest();
  // Tiles that reach the border of the whole come first, because their points make most other tiles unnecessary.
  std::vector<std::pair<int, std::size_t>> order;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const Bounds box = box_of(manifest, source.entry(i).tile);
    int inside = 0;
    for (int axis = 0; axis < 2; ++axis)
      inside += (box.lo[axis] > manifest.bounds.lo[axis]) + (box.hi[axis] < manifest.bounds.hi[axis]);
    order.emplace_back(inside, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<Point> hull;
  for (const auto& [inside, i] : order) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while looking for the hull");
    if (covers(hull, box_of(manifest, source.entry(i).tile))) continue;
    BOOST_OUTCOME_TRY(stored, source.read(i, {.cells = false}));
    for (const Point& p : stored.mesh.points) hull.push_back({p.x, p.y, 0});
    make_hull(hull);
  }
  return hull;
}

}  // namespace tessera::query

#include "tests/region/region_case.h"

#include <algorithm>
#include <array>
#include <random>
#include <span>
#include <unordered_map>
#include <vector>

#include "src/geometry/predicates/exact/predicates.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "src/result/region/meets.h"
#include "src/result/region/regions.h"
#include "tests/region/memory_units.h"

namespace tessera::testing_region {
namespace {

using Random = std::mt19937_64;
constexpr int regions_a_case = 8;

std::vector<LocalPoint> random_cloud(Random& random, int dimension) {
  const auto& kinds = cloud_kinds();
  auto points = make_cloud(kinds[random() % kinds.size()], dimension, 12 + random() % 300, random());
  // Equal points, as at the borders of files: some of them before, some after the one that they repeat.
  for (std::size_t i = points.size() / 8; i-- > 0;) points.push_back(points[random() % points.size()]);
  std::shuffle(points.begin(), points.end(), random);
  if (random() % 2 == 0)  // files of neighbouring points
    std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  for (std::size_t i = 0; i < points.size(); ++i) points[i].id = PointId{i};
  return points;
}

// Mostly small, between coordinates that points have: often with points, facets and vertices on its sides; sometimes
// flat, sometimes without bounds, sometimes beside the points.
Box random_region(Random& random, const std::vector<LocalPoint>& points, int dimension) {
  const Point a = points[random() % points.size()].at, b = points[random() % points.size()].at;
  const double part = random() % 3 == 0 ? 1 : random() % 2 == 0 ? 0.1 : 0.5;
  Box box;
  for (int axis = 0; axis < dimension; ++axis) {
    double far = a[axis] + (b[axis] - a[axis]) * part;
    if (random() % 8 == 0) far = a[axis];
    const double shift = random() % 16 == 0 ? 2 * (b[axis] - a[axis]) : 0;
    box.lo[axis] = std::min(a[axis], far) + shift;
    box.hi[axis] = std::max(a[axis], far) + shift;
    if (random() % 16 == 0) box.lo[axis] = -INFINITY;
    if (random() % 16 == 0) box.hi[axis] = INFINITY;
  }
  return box;
}

class Expected {
 public:
  Expected(const std::vector<LocalPoint>& points, int dimension)
      : cells_(global_delaunay(points, dimension)), corners_(static_cast<std::size_t>(dimension) + 1) {
    for (const auto& p : points) {
      at_[p.id] = p.at;
      bounds_.add(p.at);
    }
  }
  bool empty() const { return cells_.empty(); }

  std::vector<IdCell> meeting(const Box& region) const {
    Bounds box;
    for (int axis = 0; axis < 3; ++axis) {  // no cell has a point beyond
      box.lo[axis] = std::max(region.lo[axis], bounds_.lo[axis]);
      box.hi[axis] = std::min(region.hi[axis], bounds_.hi[axis]);
      if (box.lo[axis] > box.hi[axis]) return {};
    }
    std::vector<IdCell> met;
    for (const IdCell& cell : cells_) {
      std::array<Point, 4> simplex{};
      for (std::size_t i = 0; i < corners_; ++i) simplex[i] = at_.at(cell[i]);
      const int side = corners_ == 4 ? exact::orientation_3(simplex[0], simplex[1], simplex[2], simplex[3])
                                     : exact::orientation_2(simplex[0], simplex[1], simplex[2]);
      if (side < 0) std::swap(simplex[0], simplex[1]);
      if (meets(std::span(simplex).first(corners_), box)) met.push_back(cell);
    }
    return met;
  }

 private:
  std::vector<IdCell> cells_;
  std::unordered_map<PointId, Point> at_;
  Bounds bounds_;
  std::size_t corners_;
};

std::string check_partial(const RegionCells& answer, const std::vector<IdCell>& expected) {
  RegionCells final = answer;
  for (std::size_t i = 0; i < answer.final.size(); ++i) final.mesh.cell_ghost[i] = answer.final[i] == 0;
  const auto cells = main_cells(std::span(&final.mesh, 1));
  std::vector<IdCell> wrong;
  std::set_difference(cells.begin(), cells.end(), expected.begin(), expected.end(), std::back_inserter(wrong));
  if (!wrong.empty()) return "called final: " + difference({}, wrong);
  if (answer.complete) return difference(expected, cells);
  return answer.needed.empty() ? "does not say what is needed" : "";
}

}  // namespace

std::string check_case(std::uint64_t seed, std::uint64_t& regions, std::uint64_t& unread) {
  Random random(seed);
  const int dimension = 2 + static_cast<int>(random() % 2);
  const auto points = random_cloud(random, dimension);
  const Expected expected(points, dimension);
  const bool octree = random() % 3 != 0;
  auto units =
      octree ? octree_units(points, dimension, 1 + random() % 20, random()) : file_units(points, 1 + random() % 20);
  Regions cloud(std::move(units), dimension, 0);
  for (int i = 0; i < regions_a_case; ++i) {
    ++regions;
    const Box region = random_region(random, points, dimension);
    if (random() % 2 == 0) cloud.forget();
    const auto cells = expected.meeting(region);
    const auto fail = [&](const std::string& what) { return "region " + std::to_string(i) + ": " + what; };
    const auto answer = cloud.ask(region, {});
    if (answer.has_error()) return fail(answer.error().where);
    if (!answer.value().complete) return fail("is not complete, without a limit");
    const auto wrong = difference(cells, main_cells(std::span(&answer.value().mesh, 1)));
    if (!wrong.empty()) return fail(wrong);
    unread += answer.value().figures.units_used < answer.value().figures.units;
    const auto part = cloud.ask(region, {.max_points = 10 + random() % points.size(), .partial = true});
    if (part.has_error() && part.error().code != Errc::memory) return fail(part.error().where);
    if (part.has_value()) {
      const auto untrue = check_partial(part.value(), cells);
      if (!untrue.empty()) return fail("with a limit: " + untrue);
    }
  }
  return "";
}

}  // namespace tessera::testing_region

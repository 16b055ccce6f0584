#include "tests/region/memory_units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tessera::testing_region {
namespace {

constexpr int levels_max = 12;

struct Cube {
  Point lo;
  double side = 0;
};

void add_nodes(std::vector<LocalPoint> points, const Cube& cube, int level, int dimension, std::size_t node_points,
               std::mt19937_64& random, std::vector<MemoryUnits::Unit>& units) {
  if (points.empty()) return;
  std::shuffle(points.begin(), points.end(), random);
  const std::size_t here = level == levels_max ? points.size() : std::min(points.size(), node_points);
  MemoryUnits::Unit unit;
  unit.points.assign(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(here));
  unit.bounds.lo = unit.bounds.hi = cube.lo;
  for (int axis = 0; axis < dimension; ++axis) unit.bounds.hi[axis] += cube.side;
  units.push_back(std::move(unit));
  std::array<std::vector<LocalPoint>, 8> children;
  const double half = cube.side / 2;
  for (std::size_t i = here; i < points.size(); ++i) {
    std::size_t child = 0;
    for (int axis = 0; axis < dimension; ++axis)
      if (points[i].at[axis] >= cube.lo[axis] + half) child |= std::size_t{1} << axis;
    children[child].push_back(points[i]);
  }
  for (std::size_t child = 0; child < 8; ++child) {
    Cube at{cube.lo, half};
    for (int axis = 0; axis < dimension; ++axis)
      if ((child >> axis & 1) != 0) at.lo[axis] += half;
    add_nodes(std::move(children[child]), at, level + 1, dimension, node_points, random, units);
  }
}

}  // namespace

MemoryUnits::MemoryUnits(std::vector<Unit> units) : units_(std::move(units)) {
  for (const auto& unit : units_) list_.push_back({unit.points.size(), 32 * unit.points.size(), unit.bounds});
}

Status MemoryUnits::read(std::span<const std::size_t> units,
                         const std::function<Status(std::size_t, CloudBatch&)>& visit) {
  for (const std::size_t unit : units) {
    read_.push_back(unit);
    bytes_read_ += list_[unit].bytes;
    CloudBatch batch{.points = units_[unit].points, .rows = {}};
    BOOST_OUTCOME_TRYV(visit(unit, batch));
  }
  return success();
}

// The cube is a power of two wide and stands on a multiple of it: halves are exact where the points are not far off,
// and else only the order of the nodes would suffer, not that their boxes hold their points, which is seen to here.
std::unique_ptr<MemoryUnits> octree_units(const std::vector<LocalPoint>& points, int dimension, std::size_t node_points,
                                          std::uint64_t seed) {
  Bounds bounds;
  for (const auto& p : points) bounds.add(p.at);
  Cube cube{bounds.lo, 0};
  for (int axis = 0; axis < dimension; ++axis) cube.side = std::max(cube.side, bounds.hi[axis] - bounds.lo[axis]);
  cube.side = std::exp2(std::ceil(std::log2(cube.side)));
  std::vector<MemoryUnits::Unit> units;
  std::mt19937_64 random(seed);
  add_nodes(points, cube, 0, dimension, node_points, random, units);
  for (auto& unit : units)
    for (const auto& p : unit.points) unit.bounds.add(p.at);
  return std::make_unique<MemoryUnits>(std::move(units));
}

std::unique_ptr<MemoryUnits> file_units(const std::vector<LocalPoint>& points, std::size_t files) {
  std::vector<LocalPoint> sorted = points;
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  std::vector<MemoryUnits::Unit> units(files);
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    auto& unit = units[i * files / sorted.size()];
    unit.points.push_back(sorted[i]);
    unit.bounds.add(sorted[i].at);
  }
  std::erase_if(units, [](const auto& unit) { return unit.points.empty(); });
  return std::make_unique<MemoryUnits>(std::move(units));
}

}  // namespace tessera::testing_region

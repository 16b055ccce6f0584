#include "src/result/tileset/surface.h"

#include <meshoptimizer.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace tessera::tileset {
namespace {

// Copies triangles of one surface, with their vertices.
class Picker {
 public:
  explicit Picker(const Surface& from) : from_(from), number_(from.vertices.size(), none) {}

  Surface pick(std::span<const std::uint32_t> triangles) {
    Surface part;
    part.corners.reserve(3 * triangles.size());
    for (const std::uint32_t triangle : triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = from_.corners[3 * std::size_t{triangle} + k];
        if (number_[v] == none) {
          number_[v] = static_cast<std::uint32_t>(part.vertices.size());
          part.vertices.push_back(from_.vertices[v]);
          used_.push_back(v);
        }
        part.corners.push_back(number_[v]);
      }
    for (const std::uint32_t v : used_) number_[v] = none;
    used_.clear();
    return part;
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  const Surface& from_;
  std::vector<std::uint32_t> number_;
  std::vector<std::uint32_t> used_;
};

// Twice the middle of a triangle's extent. Only the order of these numbers is used.
double middle(const Surface& surface, std::uint32_t triangle, int axis) {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = surface.vertices[surface.corners[3 * std::size_t{triangle} + k]].at[axis];
    lo = std::min(lo, at);
    hi = std::max(hi, at);
  }
  return lo + hi;
}

// Reorders the triangles so that those of the first half come first along the longest axis of the surface.
std::size_t halve(const Surface& surface, std::span<std::uint32_t> triangles, int axes) {
  double lo[3], hi[3];
  for (int axis = 0; axis < axes; ++axis) {
    lo[axis] = std::numeric_limits<double>::infinity();
    hi[axis] = -lo[axis];
    for (const std::uint32_t t : triangles) {
      const double at = middle(surface, t, axis);
      lo[axis] = std::min(lo[axis], at);
      hi[axis] = std::max(hi[axis], at);
    }
  }
  int axis = 0;
  for (int other = 1; other < axes; ++other)
    if (hi[other] - lo[other] > hi[axis] - lo[axis]) axis = other;
  const std::size_t half = triangles.size() / 2;
  std::vector<std::pair<double, std::uint32_t>> order;
  order.reserve(triangles.size());
  for (const std::uint32_t t : triangles) order.emplace_back(middle(surface, t, axis), t);
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end());
  for (std::size_t i = 0; i < triangles.size(); ++i) triangles[i] = order[i].second;
  std::sort(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(half));
  std::sort(triangles.begin() + static_cast<std::ptrdiff_t>(half), triangles.end());
  return half;
}

// The ends of the border edges, ascending: edges that triangles pass more often one way than the other.
std::vector<std::uint32_t> ends_of_border(const Surface& surface) {
  std::vector<std::array<std::uint32_t, 3>> edges;  // lower end, higher end, whether it is passed downwards
  edges.reserve(surface.corners.size());
  for (std::size_t i = 0; i < surface.corners.size(); ++i) {
    const std::uint32_t from = surface.corners[i], to = surface.corners[i % 3 == 2 ? i - 2 : i + 1];
    edges.push_back({std::min(from, to), std::max(from, to), from < to ? 0U : 1U});
  }
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint32_t> ends;
  for (std::size_t i = 0; i < edges.size();) {
    std::ptrdiff_t sum = 0;
    const std::size_t first = i;
    for (; i < edges.size() && edges[i][0] == edges[first][0] && edges[i][1] == edges[first][1]; ++i)
      sum += edges[i][2] == 0 ? 1 : -1;
    if (sum != 0) ends.insert(ends.end(), {edges[first][0], edges[first][1]});
  }
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  return ends;
}

}  // namespace

Bounds Surface::bounds() const {
  Bounds bounds;
  for (const SurfaceVertex& v : vertices) bounds.add(v.at);
  return bounds;
}

std::vector<Surface> quarters(const Surface& surface, int axes) {
  std::vector<std::uint32_t> all(surface.triangles());
  std::iota(all.begin(), all.end(), 0u);
  Picker picker(surface);
  std::vector<Surface> parts;
  const std::span triangles(all);
  const std::size_t half = halve(surface, triangles, axes);
  for (const std::span side : {triangles.first(half), triangles.subspan(half)}) {
    if (side.empty()) continue;
    const std::size_t quarter = halve(surface, side, axes);
    for (const std::span part : {side.first(quarter), side.subspan(quarter)})
      if (!part.empty()) parts.push_back(picker.pick(part));
  }
  return parts;
}

Surface join(std::span<const Surface* const> parts) {
  Surface joined;
  std::unordered_map<std::uint64_t, std::uint32_t> number;  // by id
  for (const Surface* part : parts) {
    std::vector<std::uint32_t> in_joined;
    in_joined.reserve(part->vertices.size());
    for (const SurfaceVertex& v : part->vertices) {
      const auto [at, is_new] = number.emplace(v.id.value, static_cast<std::uint32_t>(joined.vertices.size()));
      if (is_new) joined.vertices.push_back(v);
      in_joined.push_back(at->second);
    }
    for (const std::uint32_t corner : part->corners) joined.corners.push_back(in_joined[corner]);
  }
  return joined;
}

Surface simplify(const Surface& surface, std::size_t triangles) {
  if (surface.triangles() <= triangles) return surface;
  const auto n = static_cast<std::uint32_t>(surface.vertices.size());
  // Floats relative to the middle. Rounding affects which vertices are removed, not where the others are.
  const Bounds bounds = surface.bounds();
  std::vector<std::array<float, 3>> positions;
  positions.reserve(surface.vertices.size());
  for (const SurfaceVertex& v : surface.vertices) {
    auto& at = positions.emplace_back();
    for (int axis = 0; axis < 3; ++axis)
      at[static_cast<std::size_t>(axis)] = static_cast<float>(v.at[axis] - (bounds.lo[axis] / 2 + bounds.hi[axis] / 2));
  }
  // What meshopt_simplify() takes for the border is not all of it: an edge that was folded onto it hides it, and
  // vertices at one place count as one. So each end of the border gets an extra triangle that touches nothing else,
  // which locks the vertex.
  std::vector<std::uint32_t> corners = surface.corners;
  const std::vector<std::uint32_t> fixed = ends_of_border(surface);
  for (const std::uint32_t v : fixed) {
    corners.push_back(v);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      corners.push_back(static_cast<std::uint32_t>(positions.size()));
      std::array<float, 3> near = positions[v];
      near[axis] = std::nextafter(near[axis], std::numeric_limits<float>::infinity());
      positions.push_back(near);
    }
  }
  std::vector<std::uint32_t> made(corners.size());
  constexpr float any_error = 1e9F;  // only the number of triangles counts
  const std::size_t left = meshopt_simplify(made.data(), corners.data(), corners.size(), positions[0].data(),
                                            positions.size(), sizeof positions[0], 3 * (triangles + fixed.size()),
                                            any_error, meshopt_SimplifyLockBorder, nullptr);
  Surface coarse{surface.vertices, {}};
  for (std::size_t i = 0; i < left; i += 3)
    if (made[i] < n && made[i + 1] < n && made[i + 2] < n)
      coarse.corners.insert(coarse.corners.end(), {made[i], made[i + 1], made[i + 2]});
  std::vector<std::uint32_t> all(coarse.triangles());
  std::iota(all.begin(), all.end(), 0u);
  return Picker(coarse).pick(all);
}

}  // namespace tessera::tileset

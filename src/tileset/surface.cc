#include "src/tileset/surface.h"

#include <meshoptimizer.h>
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace tessera::tileset {
namespace {

// Copies triangles of one surface, with the vertices they have.
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

// Twice the middle of a triangle's extent: all that counts is the order.
double middle(const Surface& surface, std::uint32_t triangle, int axis) {
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = surface.vertices[surface.corners[3 * std::size_t{triangle} + k]].at[axis];
    lo = std::min(lo, at);
    hi = std::max(hi, at);
  }
  return lo + hi;
}

// Reorders the triangles so that those of the first half are before the others on the longer axis of them all.
std::size_t halve(const Surface& surface, std::span<std::uint32_t> triangles) {
  double lo[2], hi[2];
  for (int axis = 0; axis < 2; ++axis) {
    lo[axis] = std::numeric_limits<double>::infinity();
    hi[axis] = -lo[axis];
    for (const std::uint32_t t : triangles) {
      const double at = middle(surface, t, axis);
      lo[axis] = std::min(lo[axis], at);
      hi[axis] = std::max(hi[axis], at);
    }
  }
  const int axis = hi[1] - lo[1] > hi[0] - lo[0] ? 1 : 0;
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

}  // namespace

Bounds Surface::bounds() const {
  Bounds bounds;
  for (const SurfaceVertex& v : vertices) bounds.add(v.at);
  return bounds;
}

std::vector<Surface> quarters(const Surface& surface) {
  std::vector<std::uint32_t> all(surface.triangles());
  std::iota(all.begin(), all.end(), 0u);
  Picker picker(surface);
  std::vector<Surface> parts;
  const std::span triangles(all);
  const std::size_t half = halve(surface, triangles);
  for (const std::span side : {triangles.first(half), triangles.subspan(half)}) {
    if (side.empty()) continue;
    const std::size_t quarter = halve(surface, side);
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
  // Floats around the middle: what is rounded decides which vertices go, not where they are.
  const Bounds bounds = surface.bounds();
  std::vector<std::array<float, 3>> positions;
  positions.reserve(surface.vertices.size());
  for (const SurfaceVertex& v : surface.vertices) {
    auto& at = positions.emplace_back();
    for (int axis = 0; axis < 3; ++axis)
      at[static_cast<std::size_t>(axis)] = static_cast<float>(v.at[axis] - (bounds.lo[axis] / 2 + bounds.hi[axis] / 2));
  }
  Surface coarse{surface.vertices, std::vector<std::uint32_t>(surface.corners.size())};
  constexpr float any_error = 1e9F;  // how many triangles there are is what is asked for
  const std::size_t left =
      meshopt_simplify(coarse.corners.data(), surface.corners.data(), surface.corners.size(),
                       positions.empty() ? nullptr : positions[0].data(), positions.size(), sizeof positions[0],
                       3 * triangles, any_error, meshopt_SimplifyLockBorder, nullptr);
  coarse.corners.resize(left);
  std::vector<std::uint32_t> all(coarse.triangles());
  std::iota(all.begin(), all.end(), 0u);
  return Picker(coarse).pick(all);
}

}  // namespace tessera::tileset

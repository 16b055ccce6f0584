// The faces that make up an alpha shape.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "src/base/point.h"

namespace tessera::alpha {

// In 2D edges are facets. The order of the kinds is the order in files.
enum class SimplexKind : std::uint8_t { facet, singular_facet, singular_edge, singular_vertex };
inline constexpr std::size_t simplex_kinds = 4;

// The number of vertices.
constexpr std::size_t corners_of(SimplexKind kind, int dimension) {
  if (kind == SimplexKind::singular_edge) return 2;
  return kind == SimplexKind::singular_vertex ? 1 : static_cast<std::size_t>(dimension);
}

struct ShapeSimplex {
  SimplexKind kind = SimplexKind::facet;
  std::array<PointId, 3> ids{};  // the unused ones are 0
  std::array<Point, 3> at{};
  // The order does not depend on tiles, because no two simplices of a kind have the same vertices.
  friend bool operator<(const ShapeSimplex& a, const ShapeSimplex& b) {
    return std::tie(a.kind, a.ids) < std::tie(b.kind, b.ids);
  }
  // Turns a triangle so that the least id comes first, which keeps the orientation.
  void begin_with_least() {
    const auto least = std::min_element(ids.begin(), ids.end()) - ids.begin();
    std::rotate(ids.begin(), ids.begin() + least, ids.end());
    std::rotate(at.begin(), at.begin() + least, at.end());
  }
  // Sorts the first `size` corners by id, for simplices without an orientation.
  void sort(std::size_t size) {
    for (std::size_t i = 1; i < size; ++i) {
      for (std::size_t j = i; j > 0 && ids[j] < ids[j - 1]; --j) {
        std::swap(ids[j], ids[j - 1]);
        std::swap(at[j], at[j - 1]);
      }
    }
  }
};

}  // namespace tessera::alpha

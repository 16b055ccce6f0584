#include "src/export/cell_filter.h"

#include <algorithm>
#include <cmath>

namespace tessera::exports {

double longest_edge(const TileMesh& mesh, std::size_t cell) {
  const bool flat = mesh.dimension == 2;
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  const auto corner = [&](std::size_t k) -> const Point& {
    return mesh.points[static_cast<std::size_t>(mesh.cells[cell * corners + k])];
  };
  const auto longest = [&](auto length) {
    double most = 0;
    for (std::size_t i = 0; i < corners; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Point &a = corner(i), &b = corner(j);
        most = std::max(most, length(a.x - b.x, a.y - b.y, flat ? 0.0 : a.z - b.z));
      }
    }
    return most;
  };
  // hypot() takes ten times as long: for squares that a double does not hold.
  constexpr double least = 1e-280, most = 1e300;
  const double square = longest([](double x, double y, double z) { return x * x + y * y + z * z; });
  if (square > least && square < most) return std::sqrt(square);
  return longest([](double x, double y, double z) { return std::hypot(x, y, z); });
}

}  // namespace tessera::exports

#include "src/result/export/cell_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "src/base/option.h"

namespace tessera::exports {

namespace {

double longest_edge_of(const TileMesh& mesh, std::size_t cell, bool flat) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::array<Point, 4> at;
  for (std::size_t k = 0; k < corners; ++k)
    at[k] = mesh.points[static_cast<std::size_t>(mesh.cells[cell * corners + k])];
  return longest_edge(std::span(at).first(corners), flat);
}

}  // namespace

double longest_edge(const TileMesh& mesh, std::size_t cell) { return longest_edge_of(mesh, cell, mesh.dimension == 2); }
double longest_edge_in_space(const TileMesh& mesh, std::size_t cell) { return longest_edge_of(mesh, cell, false); }

double longest_edge(std::span<const Point> corners, bool flat) {
  const auto longest = [&](auto length) {
    double most = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Point &a = corners[i], &b = corners[j];
        most = std::max(most, length(a.x - b.x, a.y - b.y, flat ? 0.0 : a.z - b.z));
      }
    }
    return most;
  };
  // hypot() takes ten times as long. It is used for squares that a double cannot hold.
  constexpr double least = 1e-280, most = 1e300;
  const double square = longest([](double x, double y, double z) { return x * x + y * y + z * z; });
  if (square > least && square < most) return std::sqrt(square);
  return longest([](double x, double y, double z) { return std::hypot(x, y, z); });
}

Status check_max_edge(const std::optional<double>& max_edge) {
  if (max_edge && !(std::isfinite(*max_edge) && *max_edge > 0))
    return error(Errc::usage, option("max-edge") + ": must be a length, finite and above 0");
  return success();
}

}  // namespace tessera::exports

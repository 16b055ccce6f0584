#include "src/result/export/cell_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "src/base/option.h"
#include "src/geometry/predicates/exact/circumradius.h"

namespace tessera::exports {

namespace {

struct CellCorners {
  CellCorners(const TileMesh& mesh, std::size_t cell) : count(static_cast<std::size_t>(mesh.dimension) + 1) {
    for (std::size_t k = 0; k < count; ++k) at[k] = mesh.points[static_cast<std::size_t>(mesh.cells[cell * count + k])];
  }
  std::span<const Point> all() const { return std::span(at).first(count); }
  std::size_t count;
  std::array<Point, 4> at;
};

Status check_length(const char* key, const std::optional<double>& length) {
  if (length && !(std::isfinite(*length) && *length > 0))
    return error(Errc::usage, option(key) + ": must be a length, finite and above 0");
  return success();
}

}  // namespace

double longest_edge(const TileMesh& mesh, std::size_t cell) {
  return longest_edge(CellCorners(mesh, cell).all(), mesh.dimension == 2);
}
double longest_edge_in_space(const TileMesh& mesh, std::size_t cell) {
  return longest_edge(CellCorners(mesh, cell).all(), false);
}

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

Status check_sizes(const CellSizes& sizes) {
  BOOST_OUTCOME_TRYV(check_length("max-edge", sizes.max_edge));
  return check_length("max-radius", sizes.max_radius);
}

double circumradius_of(const TileMesh& mesh, std::size_t cell) {
  return exact::circumradius_up(CellCorners(mesh, cell).all(), mesh.dimension == 2);
}

bool CellFilter::has_radius(const TileMesh& mesh, std::size_t cell, double most) {
  return exact::compare_circumradius(CellCorners(mesh, cell).all(), mesh.dimension == 2, most) <= 0;
}

}  // namespace tessera::exports

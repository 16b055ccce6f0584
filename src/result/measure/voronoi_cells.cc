#include "src/result/measure/voronoi_cells.h"

#include <algorithm>
#include <limits>

namespace tessera::voronoi {

VoronoiCell open_cell(Border border, std::uint32_t neighbours) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const double value = border == Border::hull ? std::numeric_limits<double>::infinity() : nan;
  return {.volume = value, .surface = value, .centroid = {nan, nan, nan}, .neighbours = neighbours};
}

std::uint32_t count_neighbours(const TileMesh& mesh, std::size_t vertex, std::span<const std::uint32_t> star) {
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  std::vector<std::int32_t> near;
  for (const std::uint32_t cell : star)
    for (const std::int32_t v : std::span(mesh.cells).subspan(cell * corners, corners))
      if (static_cast<std::size_t>(v) != vertex) near.push_back(v);
  std::sort(near.begin(), near.end());
  return static_cast<std::uint32_t>(std::unique(near.begin(), near.end()) - near.begin());
}

}  // namespace tessera::voronoi

#include "src/tile/final_cells.h"

#include <algorithm>

#include "src/tile/circumsphere.h"

namespace tessera {

std::vector<std::uint8_t> find_final(const CellList& list, std::span<const Point> points, const Box& box,
                                     int dimension) {
  const int corners = dimension + 1;
  const std::size_t cells = list.vertices.size() / corners;
  std::vector<std::uint8_t> is_final(cells, 0);
  for (std::size_t c = 0; c < cells; ++c) {
    const Vertex* v = &list.vertices[c * corners];
    const auto own = [&](int i) { return v[i] != infinite_vertex && v[i] <= points.size(); };
    if (!own(0) || !own(1) || !own(2) || (dimension == 3 && !own(3))) continue;
    const Ball ball = dimension == 3
                          ? circumsphere(points[v[0] - 1], points[v[1] - 1], points[v[2] - 1], points[v[3] - 1])
                          : circumcircle(points[v[0] - 1], points[v[1] - 1], points[v[2] - 1]);
    is_final[c] = surely_inside(ball, box, dimension);
  }
  return is_final;
}

FinalCells extract_final(const CellList& list, const std::vector<std::uint8_t>& is_final, int dimension) {
  const int corners = dimension + 1;
  std::vector<std::int32_t> place(is_final.size(), FinalCells::open);
  std::int32_t kept = 0;
  for (std::size_t c = 0; c < is_final.size(); ++c) {
    if (is_final[c]) place[c] = kept++;
  }
  FinalCells out;
  out.vertices.reserve(static_cast<std::size_t>(kept) * corners);
  out.neighbors.reserve(static_cast<std::size_t>(kept) * corners);
  for (std::size_t c = 0; c < is_final.size(); ++c) {
    if (!is_final[c]) continue;
    for (int i = 0; i < corners; ++i) {
      out.vertices.push_back(list.vertices[c * corners + i] - 1);
      out.neighbors.push_back(place[list.neighbors[c * corners + i]]);
    }
  }
  return out;
}

CellKey cell_key(const std::uint32_t* vertices, int dimension) {
  CellKey key{~0u, ~0u, ~0u, ~0u};
  std::copy_n(vertices, dimension + 1, key.begin());
  std::sort(key.begin(), key.end());
  return key;
}

}  // namespace tessera

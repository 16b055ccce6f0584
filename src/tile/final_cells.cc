#include "src/tile/final_cells.h"

#include <algorithm>
#include <utility>

namespace tessera {

FinalCells extract_final(const CellList& list, const std::vector<std::uint8_t>& open, int dimension) {
  const int corners = dimension + 1;
  std::vector<std::uint32_t> place(open.size(), FinalCells::open);
  std::uint32_t kept = 0;
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (!open[c]) place[c] = kept++;
  }
  FinalCells out;
  out.vertices.reserve(static_cast<std::size_t>(kept) * corners);
  out.neighbors.reserve(static_cast<std::size_t>(kept) * corners);
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (open[c]) continue;
    for (int i = 0; i < corners; ++i) {
      out.vertices.push_back(list.vertices[c * corners + i]);
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

#include "src/result/voronoi/star_order.h"

#include <algorithm>

namespace tessera::voronoi {

bool StarOrder::order(std::span<Wedge> wedges, OrderedStar& star) {
  star.around.clear();
  star.cells.clear();
  star.on_hull = false;
  if (wedges.empty()) return false;
  ends_.clear();
  for (const Wedge& wedge : wedges) ends_.push_back(wedge.to);
  const auto by_from = [](const Wedge& a, const Wedge& b) { return a.from < b.from; };
  std::sort(wedges.begin(), wedges.end(), by_from);
  std::sort(ends_.begin(), ends_.end());
  const Wedge* at = &wedges.front();
  for (const Wedge& wedge : wedges) {
    if (std::binary_search(ends_.begin(), ends_.end(), wedge.from)) continue;
    if (star.on_hull) return false;
    star.on_hull = true;
    at = &wedge;
  }
  const std::int32_t first = at->from;
  for (std::size_t left = wedges.size(); left > 0; --left) {
    star.around.push_back(at->from);
    star.cells.push_back(at->cell);
    const std::int32_t to = at->to;
    if (left == 1) {
      if (star.on_hull) star.around.push_back(to);
      return star.on_hull || to == first;
    }
    const auto next = std::lower_bound(wedges.begin(), wedges.end(), Wedge{to, 0, 0}, by_from);
    if (next == wedges.end() || next->from != to || to == first) return false;
    at = &*next;
  }
  return false;
}

bool StarOrder::order(const TileMesh& mesh, std::size_t vertex, std::span<const std::uint32_t> cells,
                      OrderedStar& star) {
  wedges_.clear();
  for (const std::uint32_t cell : cells) {
    const std::int32_t* corner = mesh.cells.data() + std::size_t{cell} * 3;
    std::size_t own = 0;
    while (own < 2 && static_cast<std::size_t>(corner[own]) != vertex) ++own;
    wedges_.push_back({corner[(own + 1) % 3], corner[(own + 2) % 3], cell});
  }
  return order(wedges_, star);
}

}  // namespace tessera::voronoi

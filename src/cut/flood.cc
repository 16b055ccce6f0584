#include "src/cut/flood.h"

#include <utility>

namespace tessera::cut {

Flood::Flood(const CutGraph& graph) : graph_(graph), reached_(graph.cells()) {
  for (std::uint32_t cell = 0; cell < graph_.cells(); ++cell)
    if (graph_.excess[cell] > 0) reach(cell);
}

void Flood::reach(std::uint32_t cell) {
  if (!reached_.insert(cell)) return;
  met_deficit_ |= graph_.excess[cell] < 0;
  queue_.push_back(cell);
}

void Flood::enter(std::uint32_t border) { reach(graph_.borders[border].arc >> 2u); }

std::vector<std::uint32_t> Flood::run() {
  std::vector<std::uint32_t> crossed;
  while (!queue_.empty()) {
    const std::uint32_t cell = queue_.back();
    queue_.pop_back();
    for (Arc arc = 4 * cell; arc < 4 * cell + 4; ++arc) {
      if (graph_.capacity[arc] == 0) continue;
      const Arc back = graph_.back[arc];
      if (is_inner(back)) {
        reach(back >> 2u);
      } else if (back != no_arc) {
        crossed.push_back(back & ~border_bit);
      }
    }
  }
  return crossed;
}

}  // namespace tessera::cut

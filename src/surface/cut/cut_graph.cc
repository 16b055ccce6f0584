#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

bool CutGraph::sound() const {
  const std::size_t arcs = 4 * excess.size();
  if (excess.size() > cells_max || capacity.size() != arcs || back.size() != arcs) return false;
  std::size_t at_borders = 0;
  for (std::size_t arc = 0; arc < arcs; ++arc) {
    const Arc across = back[arc];
    if (across == no_arc) {
      if (capacity[arc] != 0) return false;
    } else if (is_inner(across)) {
      if (across >= arcs || back[across] != arc || across >> 2u == arc >> 2u) return false;
    } else {
      const std::size_t number = across & ~border_bit;
      if (number >= borders.size() || borders[number].arc != arc) return false;
      ++at_borders;
    }
  }
  return at_borders == borders.size();
}

}  // namespace tessera::cut

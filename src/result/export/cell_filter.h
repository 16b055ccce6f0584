// Which main cells an export holds: all, or those without long edges.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera::exports {

// The length of a cell's longest edge, in units of the coordinates, right to the last bit but two; infinite when it is
// more than a double holds. In 2D it is that in the plane: heights do not count.
double longest_edge(const TileMesh& mesh, std::size_t cell);
// Where heights, which are the vertices' z then, count in 2D, too.
double longest_edge_in_space(const TileMesh& mesh, std::size_t cell);
// The same of any points: in the plane if `flat`.
double longest_edge(std::span<const Point> corners, bool flat);

// Error usage when there is one, and it is no length, finite and above 0.
Status check_max_edge(const std::optional<double>& max_edge);

class CellFilter {
 public:
  // Cells with an edge longer than `max_edge` are left out.
  explicit CellFilter(std::optional<double> max_edge)
      : max_edge_(max_edge.value_or(std::numeric_limits<double>::infinity())), active_(max_edge.has_value()) {}
  bool active() const { return active_; }
  // Whether the cell is exported: main, and short enough.
  bool keeps(const TileMesh& mesh, std::size_t cell) const {
    return mesh.cell_ghost[cell] == 0 && (!active_ || longest_edge(mesh, cell) <= max_edge_);
  }

 private:
  double max_edge_;
  bool active_;
};

}  // namespace tessera::exports

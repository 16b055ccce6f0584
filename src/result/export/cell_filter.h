// Selects the main cells of an export: all, or those without long edges.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"

namespace tessera::exports {

// The length of a cell's longest edge, in units of the coordinates, exact up to the last two bits; infinite when a
// double cannot hold it. In 2D it is measured in the plane, without heights.
double longest_edge(const TileMesh& mesh, std::size_t cell);
// The same with heights, which are the z of the vertices, in 2D, too.
double longest_edge_in_space(const TileMesh& mesh, std::size_t cell);
// The same for any points; in the plane if `flat`.
double longest_edge(std::span<const Point> corners, bool flat);

// Error usage when `max_edge` has a value that is not finite or not above 0.
Status check_max_edge(const std::optional<double>& max_edge);

class CellFilter {
 public:
  // Leaves out cells with an edge longer than `max_edge`.
  explicit CellFilter(std::optional<double> max_edge)
      : max_edge_(max_edge.value_or(std::numeric_limits<double>::infinity())), active_(max_edge.has_value()) {}
  bool active() const { return active_; }
  // Returns true if the cell is exported: it is main, and its edges are short enough.
  bool keeps(const TileMesh& mesh, std::size_t cell) const {
    return mesh.cell_ghost[cell] == 0 && (!active_ || longest_edge(mesh, cell) <= max_edge_);
  }

 private:
  double max_edge_;
  bool active_;
};

}  // namespace tessera::exports

// Selects the main cells of an export: all, or those without long edges and large circumradii.
#pragma once

#include <cstddef>
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

// Which cells count: those with no longer edge, and with no larger circumradius, compared exactly. Both are in units of
// the coordinates, and in 2D measured in the plane, without heights. Nothing: no limit.
struct CellSizes {
  std::optional<double> max_edge = {}, max_radius = {};
};

// Error usage when a limit has a value that is not finite or not above 0.
Status check_sizes(const CellSizes& sizes);
// The circumradius of a cell, rounded up; a cell is within every limit that is at least this number.
double circumradius_of(const TileMesh& mesh, std::size_t cell);

class CellFilter {
 public:
  explicit CellFilter(const CellSizes& sizes) : sizes_(sizes) {}
  bool active() const { return sizes_.max_edge || sizes_.max_radius; }
  // Returns true if the cell is within the limits.
  bool fits(const TileMesh& mesh, std::size_t cell) const {
    return (!sizes_.max_edge || longest_edge(mesh, cell) <= *sizes_.max_edge) &&
           (!sizes_.max_radius || has_radius(mesh, cell, *sizes_.max_radius));
  }
  // Returns true if the cell is exported: it is main, and within the limits.
  bool keeps(const TileMesh& mesh, std::size_t cell) const { return mesh.cell_ghost[cell] == 0 && fits(mesh, cell); }

 private:
  static bool has_radius(const TileMesh& mesh, std::size_t cell, double most);
  CellSizes sizes_;
};

}  // namespace tessera::exports

// Compares a result with CGAL's triangulation of all vertices, in memory: slow, but independent. Of a periodic result
// CGAL triangulates three copies along each axis with a period (docs/periodic-design.md says why that is enough).
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/verify/cell_ref.h"

namespace tessera {

class AgainstCgal {
 public:
  AgainstCgal(int dimension, const Period& period, std::stop_token stop)
      : dimension_(dimension), period_(period), stop_(std::move(stop)) {}
  // Adds the tile's own vertices and main cells.
  void add(const TileMesh& mesh);
  // Triangulates and compares the sets of cells. Errors: not_delaunay, with the first cell that only one of the two
  // has; interrupted, soon after a stop is requested.
  Status compare(const std::filesystem::path& out);

 private:
  Status compare_all(const std::filesystem::path& out);  // throws Stopped

  void add_copies();  // of the points
  // Leaves each cell that has a point itself, up to shifts.
  void keep_one_copy(std::vector<IdSet>& cells) const;

  int dimension_;
  Period period_;
  std::stop_token stop_;
  std::vector<Point> points_;  // in the order of the tiles, which is along Hilbert curves
  std::vector<PointId> ids_;   // of points_
  std::vector<IdSet> cells_;
};

}  // namespace tessera

#include "src/result/store/mesh_checks.h"

#include <cmath>
#include <limits>
#include <string>

namespace tessera::store {

Status check_values(const TileMesh& mesh, const CorruptArray& corrupt) {
  const auto corners = static_cast<std::size_t>(mesh.dimension + 1);
  const std::size_t n = mesh.points.size(), m = mesh.cell_ghost.size();
  if (n > std::numeric_limits<std::int32_t>::max()) return corrupt("Points", "has more than 2^31 points");
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_finite(mesh.points[i])) return corrupt("Points", "point " + std::to_string(i) + " is not finite");
    for (int axis = 0; axis < 3; ++axis) {
      if (mesh.points[i][axis] == 0 && std::signbit(mesh.points[i][axis]))
        return corrupt("Points", "point " + std::to_string(i) + " has the coordinate -0, which no vertex has");
    }
    if (mesh.dimension == 2 && mesh.points[i].z != 0)
      return corrupt("Points", "point " + std::to_string(i) + " of a plane triangulation has a z");
    if (mesh.point_ghost[i] > 1)
      return corrupt("PointData/vtkGhostType", "point " + std::to_string(i) + " is neither 0 nor 1");
  }
  for (std::size_t i = 0; i < m; ++i) {
    const std::int32_t* cell = mesh.cells.data() + i * corners;
    for (std::size_t k = 0; k < corners; ++k) {
      if (cell[k] < 0 || static_cast<std::size_t>(cell[k]) >= n)
        return corrupt("Cells/connectivity", "cell " + std::to_string(i) + " has vertex " + std::to_string(cell[k]) +
                                                 ", which does not exist");
      for (std::size_t j = 0; j < k; ++j)
        if (cell[j] == cell[k])
          return corrupt("Cells/connectivity", "cell " + std::to_string(i) + " has the same vertex twice");
    }
    if (mesh.cell_ghost[i] > 1)
      return corrupt("CellData/vtkGhostType", "cell " + std::to_string(i) + " is neither 0 nor 1");
  }
  for (std::size_t i = 0; i < mesh.cell_final.size(); ++i)
    if (mesh.cell_final[i] > 1) return corrupt("CellData/final", "cell " + std::to_string(i) + " is neither 0 nor 1");
  for (std::size_t i = 0; i < mesh.neighbors.size(); ++i)
    if (mesh.neighbors[i] < -2 || (mesh.neighbors[i] >= 0 && static_cast<std::size_t>(mesh.neighbors[i]) >= m))
      return corrupt("CellData/neighbors", "cell " + std::to_string(i / corners) + " has neighbour " +
                                               std::to_string(mesh.neighbors[i]) + ", which does not exist");
  return success();
}

}  // namespace tessera::store

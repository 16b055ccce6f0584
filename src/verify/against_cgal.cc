#include "src/verify/against_cgal.h"

#include <algorithm>
#include <string>

#include "src/kernel/kernel.h"

namespace tessera {

void AgainstCgal::add(const TileMesh& mesh) {
  const auto corners = static_cast<std::size_t>(dimension_) + 1;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (mesh.point_ghost[i] != 0) continue;
    points_.push_back(mesh.points[i]);
    ids_.push_back(mesh.ids[i]);
  }
  for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
    if (mesh.cell_ghost[c] != 0) continue;
    IdSet ids{padding_id, padding_id, padding_id, padding_id};
    for (std::size_t k = 0; k < corners; ++k) ids[k] = mesh.ids[static_cast<std::size_t>(mesh.cells[c * corners + k])];
    std::sort(ids.begin(), ids.end());
    cells_.push_back(ids);
  }
}

Status AgainstCgal::compare(const std::filesystem::path& out) {
  const auto corners = static_cast<std::size_t>(dimension_) + 1;
  const auto wrong = [&](const IdSet& cell, const std::string& reason) {
    return error(Errc::not_delaunay, out.string() + ": the cell of vertices " + text_of(cell) + " " + reason);
  };
  std::sort(cells_.begin(), cells_.end());
  std::vector<IdSet> expected;
  {
    const auto kernel = make_kernel(dimension_, KernelKind::cgal);
    kernel->build(points_);
    if (kernel->dimension() != dimension_)
      return error(Errc::not_delaunay, out.string() + ": the vertices span no volume");
    const CellList all = kernel->cells();
    for (std::size_t c = 0; c < all.vertices.size(); c += corners) {
      IdSet ids{padding_id, padding_id, padding_id, padding_id};
      bool finite = true;
      for (std::size_t k = 0; k < corners; ++k) {
        finite = finite && all.vertices[c + k] != infinite_vertex;
        if (finite) ids[k] = ids_[all.vertices[c + k] - 1];
      }
      if (!finite) continue;
      std::sort(ids.begin(), ids.end());
      expected.push_back(ids);
    }
  }
  std::sort(expected.begin(), expected.end());
  const auto [got, want] = std::mismatch(cells_.begin(), cells_.end(), expected.begin(), expected.end());
  if (got == cells_.end() && want == expected.end()) return success();
  if (want == expected.end() || (got != cells_.end() && *got < *want))
    return wrong(*got, "is not in CGAL's triangulation");
  return wrong(*want, "is in CGAL's triangulation, but missing here");
}

}  // namespace tessera

#include "src/verify/against_cgal.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <string>
#include <utility>

#include "src/base/ieee_arithmetic.h"

namespace tessera {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vb3 = CGAL::Triangulation_vertex_base_with_info_3<PointId, K>;
using Dt3 = CGAL::Delaunay_triangulation_3<
    K, CGAL::Triangulation_data_structure_3<Vb3, CGAL::Delaunay_triangulation_cell_base_3<K>>>;
using Vb2 = CGAL::Triangulation_vertex_base_with_info_2<PointId, K>;
using Dt2 = CGAL::Delaunay_triangulation_2<K, CGAL::Triangulation_data_structure_2<Vb2>>;

template <class Handle>
IdSet ids_of(Handle cell, int corners) {
  IdSet ids{padding_id, padding_id, padding_id, padding_id};
  for (int k = 0; k < corners; ++k) ids[static_cast<std::size_t>(k)] = cell->vertex(k)->info();
  std::sort(ids.begin(), ids.end());
  return ids;
}

// The finite cells, sorted ids each; none if the points span less than the space.
std::vector<IdSet> cells_by_cgal(const std::vector<Point>& points, const std::vector<PointId>& ids, int dimension) {
  std::vector<IdSet> cells;
  if (dimension == 3) {
    std::vector<std::pair<K::Point_3, PointId>> input;
    input.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      input.emplace_back(K::Point_3(points[i].x, points[i].y, points[i].z), ids[i]);
    const Dt3 t(input.begin(), input.end());
    if (t.dimension() < 3) return cells;
    for (const auto c : t.finite_cell_handles()) cells.push_back(ids_of(c, 4));
  } else {
    std::vector<std::pair<K::Point_2, PointId>> input;
    input.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) input.emplace_back(K::Point_2(points[i].x, points[i].y), ids[i]);
    const Dt2 t(input.begin(), input.end());
    if (t.dimension() < 2) return cells;
    for (const auto c : t.finite_face_handles()) cells.push_back(ids_of(c, 3));
  }
  return cells;
}

}  // namespace

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
  const auto wrong = [&](const IdSet& cell, const std::string& reason) {
    return error(Errc::not_delaunay, out.string() + ": the cell of vertices " + text_of(cell) + " " + reason);
  };
  std::sort(cells_.begin(), cells_.end());
  std::vector<IdSet> expected = cells_by_cgal(points_, ids_, dimension_);
  if (expected.empty()) return error(Errc::not_delaunay, out.string() + ": the vertices span no volume");
  std::sort(expected.begin(), expected.end());
  const auto [got, want] = std::mismatch(cells_.begin(), cells_.end(), expected.begin(), expected.end());
  if (got == cells_.end() && want == expected.end()) return success();
  if (want == expected.end() || (got != cells_.end() && *got < *want))
    return wrong(*got, "is not in CGAL's triangulation");
  return wrong(*want, "is in CGAL's triangulation, but missing here");
}

}  // namespace tessera

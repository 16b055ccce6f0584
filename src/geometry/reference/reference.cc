#include "src/geometry/reference/reference.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <map>
#include <utility>

#include "src/geometry/reference/differing_cells.h"

namespace tessera {
namespace {

using K = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vb3 = CGAL::Triangulation_vertex_base_with_info_3<PointId, K>;
using Dt3 = CGAL::Delaunay_triangulation_3<
    K, CGAL::Triangulation_data_structure_3<Vb3, CGAL::Delaunay_triangulation_cell_base_3<K>>>;
using Vb2 = CGAL::Triangulation_vertex_base_with_info_2<PointId, K>;
using Dt2 = CGAL::Delaunay_triangulation_2<K, CGAL::Triangulation_data_structure_2<Vb2>>;

std::vector<LocalPoint> distinct(std::span<const LocalPoint> points, int dimension) {
  std::vector<LocalPoint> list(points.begin(), points.end());
  if (dimension == 2) {
    for (LocalPoint& p : list) p.at.z = 0;
  }
  std::sort(list.begin(), list.end(),
            [](const LocalPoint& a, const LocalPoint& b) { return a.at != b.at ? a.at < b.at : a.id < b.id; });
  list.erase(std::unique(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.at == b.at; }),
             list.end());
  return list;
}

std::vector<IdCell> cells_of(std::span<const LocalPoint> points, int dimension, bool with_hull) {
  std::vector<IdCell> cells;
  const std::vector<LocalPoint> list = distinct(points, dimension);
  const auto add = [&](auto c) {
    IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
    for (int i = 0; i <= dimension; ++i) cell[i] = c->vertex(i)->info();
    std::sort(cell.begin(), cell.end());
    if (with_hull || cell[dimension] != infinite_id) cells.push_back(cell);
  };
  if (dimension == 3) {
    std::vector<std::pair<K::Point_3, PointId>> input;
    for (const auto& p : list) input.emplace_back(K::Point_3(p.at.x, p.at.y, p.at.z), p.id);
    Dt3 t(input.begin(), input.end());
    t.infinite_vertex()->info() = infinite_id;
    if (t.dimension() < 3) return {};
    for (auto c = t.all_cells_begin(); c != t.all_cells_end(); ++c) add(c);
  } else {
    std::vector<std::pair<K::Point_2, PointId>> input;
    for (const auto& p : list) input.emplace_back(K::Point_2(p.at.x, p.at.y), p.id);
    Dt2 t(input.begin(), input.end());
    t.infinite_vertex()->info() = infinite_id;
    if (t.dimension() < 2) return {};
    for (auto c = t.all_faces_begin(); c != t.all_faces_end(); ++c) add(c);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

std::string text_of(const IdCell& cell) {
  std::string out = "(";
  for (const PointId id : cell) {
    if (id != infinite_id) out += (out.size() > 1 ? " " : "") + to_string(id);
  }
  return out + ")";
}

}  // namespace

std::vector<IdCell> global_delaunay(std::span<const LocalPoint> points, int dimension) {
  return cells_of(points, dimension, false);
}

std::vector<IdCell> global_delaunay_with_hull(std::span<const LocalPoint> points, int dimension) {
  return cells_of(points, dimension, true);
}

std::vector<IdCell> main_cells(std::span<const TileMesh> meshes) {
  std::vector<IdCell> cells;
  for (const TileMesh& mesh : meshes) {
    const int corners = mesh.dimension + 1;
    for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
      if (mesh.cell_ghost[c]) continue;
      IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
      for (int i = 0; i < corners; ++i) cell[i] = mesh.ids[mesh.cells[c * corners + i]];
      std::sort(cell.begin(), cell.end());
      cells.push_back(cell);
    }
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

std::string difference(const std::vector<IdCell>& expected, const std::vector<IdCell>& got) {
  return differing_cells(expected, got, [](const IdCell& cell) { return text_of(cell); });
}

}  // namespace tessera

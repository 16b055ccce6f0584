#include "src/result/region/region_mesh.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <vector>

#include "src/base/stoppable_sort.h"
#include "src/base/stopped.h"

namespace tessera {
namespace {

constexpr std::int32_t outside = -1, elsewhere = -2;

// A cell of the mesh: its vertices in the mesh, and its corners in the list.
struct Row {
  std::array<std::int32_t, 4> vertices{};
  std::array<std::uint8_t, 4> from{};  // the corner in the list's cell of each vertex
  std::uint32_t cell = 0;
  friend bool operator<(const Row& a, const Row& b) { return a.vertices < b.vertices; }
};

// Turns the cell by an even permutation: the least vertex first and, in 3D, the least of the others second.
void turn(Row& row, std::size_t corners) {
  const auto swap = [&](std::size_t i, std::size_t j) {
    std::swap(row.vertices[i], row.vertices[j]);
    std::swap(row.from[i], row.from[j]);
  };
  const auto begin = row.vertices.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(corners);
  const auto rotate = [&](std::size_t first) {  // rotates three from `first` on
    swap(first, first + 1);
    swap(first + 1, first + 2);
  };
  if (corners == 3) {
    while (std::min_element(begin, end) != begin) rotate(0);
    return;
  }
  if (const auto least = static_cast<std::size_t>(std::min_element(begin, end) - begin); least > 0) {
    swap(0, least);
    swap(least == 1 ? 2 : 1, least == 3 ? 2 : 3);
  }
  while (std::min_element(begin + 1, end) != begin + 1) rotate(1);
}

}  // namespace

RegionMesh region_mesh(const GrowingTriangulation& triangulation, const CellList& cells, const Judgement& judgement,
                       const std::stop_token& stop) {
  StopCheck check(stop, 1 << 14);
  const std::size_t corners = static_cast<std::size_t>(triangulation.dimension()) + 1;
  const auto is_finite_cell = [&](std::size_t c) {
    const Vertex* v = &cells.vertices[c * corners];
    return std::find(v, v + corners, infinite_vertex) == v + corners;
  };
  std::vector<std::uint32_t> chosen;
  std::vector<Vertex> used;
  for (std::size_t c = 0; c < judgement.states.size(); ++c) {
    check.step();
    if (judgement.states[c] == CellState::elsewhere || !is_finite_cell(c)) continue;
    chosen.push_back(static_cast<std::uint32_t>(c));
    for (std::size_t i = 0; i < corners; ++i) used.push_back(cells.vertices[c * corners + i]);
  }
  sort_unless_stopped(used.begin(), used.end(), stop);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<std::uint32_t> order(used.size());
  std::iota(order.begin(), order.end(), 0u);
  sort_unless_stopped(order.begin(), order.end(), stop,
                      [&](auto a, auto b) { return triangulation.id(used[a]) < triangulation.id(used[b]); });

  RegionMesh part;
  TileMesh& mesh = part.mesh;
  mesh.dimension = triangulation.dimension();
  std::vector<std::int32_t> number(used.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    number[order[i]] = static_cast<std::int32_t>(i);
    mesh.points.push_back(triangulation.point(used[order[i]]));
    mesh.ids.push_back(triangulation.id(used[order[i]]));
  }
  mesh.owners.resize(used.size());
  mesh.point_ghost.resize(used.size());

  std::vector<Row> rows(chosen.size());
  for (std::size_t r = 0; r < chosen.size(); ++r) {
    check.step();
    rows[r].cell = chosen[r];
    for (std::size_t i = 0; i < corners; ++i) {
      const Vertex v = cells.vertices[chosen[r] * corners + i];
      rows[r].vertices[i] =
          number[static_cast<std::size_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin())];
      rows[r].from[i] = static_cast<std::uint8_t>(i);
    }
    turn(rows[r], corners);
  }
  sort_unless_stopped(rows.begin(), rows.end(), stop);
  std::vector<std::int32_t> place(judgement.states.size(), elsewhere);
  for (std::size_t r = 0; r < rows.size(); ++r) place[rows[r].cell] = static_cast<std::int32_t>(r);
  for (const Row& row : rows) {
    check.step();
    part.final.push_back(judgement.states[row.cell] == CellState::final);
    mesh.cell_ghost.push_back(0);
    for (std::size_t i = 0; i < corners; ++i) {
      const std::uint32_t across = cells.neighbors[row.cell * corners + row.from[i]];
      const bool hull = judgement.states[across] == CellState::final && !is_finite_cell(across);
      mesh.cells.push_back(row.vertices[i]);
      mesh.neighbors.push_back(hull ? outside : place[across]);
    }
  }
  return part;
}

}  // namespace tessera

// Cells of which nothing is kept except what `told` makes of them.
#include <algorithm>
#include <utility>

#include "src/base/check.h"
#include "src/tiling/tile/tile_triangulation.h"

namespace tessera {

std::uint64_t TileTriangulation::discard(std::span<const Point> points, const Box& box, bool quick,
                                         const Kernel::TakeVertices& told) {
  if (!kernel_->can_freeze()) {
    const FinalCells finals = reduce(points, box, quick);
    std::vector<Vertex> vertices;
    for (std::size_t c = 0; c < finals.rows.size(); ++c) {
      const Vertex* v = finals.rows[c].vertices;
      vertices.insert(vertices.end(), v, v + options_.dimension + 1);
    }
    told(vertices);
    return finals.rows.size();
  }
  check(!handed_out_ && updates_.empty(), "a tile is reduced once, before it announces");
  if (kernel_->dimension() < options_.dimension) return 0;
  throw_if_stopped(options_.stop);
  const std::uint64_t gone = kernel_->discard(
      [&](const Vertex* cell) {
        stop_check_.step();
        return surely_final(cell, points, box);
      },
      told);
  handed_out_ = true;
  if (!quick) forget_vertices(points.size());
  return gone;
}

RestOfTile TileTriangulation::collect_rest(const Kernel::TakeVertices& told) {
  std::vector<Point> at(ids_.size());  // by vertex; saved here, as the kernel forgets points with its cells
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (!is_local(v) && kernel_->alive(v)) at[v] = kernel_->point(v);
  }
  const int corners = options_.dimension + 1;
  const CellRecords rows = kernel_->take_cells();
  const bool filled = reduced_ && !kernel_->can_freeze();
  kernel_.reset();
  RestOfTile rest;
  std::vector<std::uint8_t> used(ids_.size());
  std::vector<Vertex> main;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const Vertex* v = rows[c].vertices;
    if (v[0] == CellRecord::gap || std::find(v, v + corners, infinite_vertex) != v + corners) continue;
    const auto own = std::count_if(v, v + corners, [&](Vertex w) { return is_local(w); });
    if (own == 0) continue;
    if (filled && own == corners && !open_cells_.contains(cell_key(v, options_.dimension))) continue;
    stop_check_.step();
    ++rest.cells;
    bool is_main = true;
    if (own < corners) {
      for (int i = 0; i < corners; ++i) {
        used[v[i]] = 1;
        is_main &= owners_[v[i]] >= options_.self;
      }
    }
    if (is_main) {
      ++rest.main_cells;
      main.insert(main.end(), v, v + corners);
      if (main.size() >= 16384) {
        told(main);
        main.clear();
      }
    }
  }
  told(main);
  for (Vertex v = 1; v < ids_.size(); ++v) {
    if (used[v] && !is_local(v)) rest.foreign.push_back({at[v], ids_[v], owners_[v], 0});
  }
  counts_.useful = rest.foreign.size();
  return rest;
}

}  // namespace tessera

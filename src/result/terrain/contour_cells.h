// Finds the contour lines inside a tile's cells, as pieces.
//
// A vertex at a level counts as above it. The area at or above the level then consists of whole cells and of parts of
// cells, and the contour line is the border of those of them that are not empty. So a peak, a ridge or a hollow exactly
// at a level has no line, and flat ground at the level has one where the ground falls. No line comes twice, none
// branches, and each ends only at the hull or at cells that are ignored.
//
// A point of a line stands for the edge that the line crosses, from a vertex above to a vertex below. So both ends of a
// piece are such edges, and at most two pieces end at an edge, however many meet in a vertex.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "src/base/point.h"
#include "src/base/stopped.h"
#include "src/result/export/cell_filter.h"
#include "src/result/query/column.h"
#include "src/result/query/query_tile.h"
#include "src/result/terrain/levels.h"

namespace tessera::terrain {

// An edge by the tile's numbers of its ends, the end with the lower source index first.
struct TileEdge {
  std::int32_t a = 0, b = 0;
  friend auto operator<=>(const TileEdge&, const TileEdge&) = default;
};

// A piece of a line from edge to edge, with the higher side on the left.
struct Piece {
  std::int64_t level = 0;
  TileEdge from, to;
};

class ContourCells {
 public:
  // Ignores cells that the filter leaves out, cells that do not meet the box, and cells with a corner without a finite
  // value. `tile` has rows. Throws Stopped.
  ContourCells(const query::QueryTile& tile, const query::Column& column, const Levels& levels,
               const exports::CellFilter& filter, const std::optional<Bounds>& box, const std::stop_token& stop);

  // The lowest level of a cell, and one above the highest; equal when there is none.
  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return end_; }
  // True if a value is more than Levels::number_max levels away; then there are no pieces.
  bool too_far() const { return too_far_; }
  // The number of pieces of all levels in main cells.
  std::uint64_t pieces() const;
  // An upper bound of the number of pieces of each level, from begin() on.
  std::vector<std::uint64_t> most_pieces() const;
  // Where the level crosses the edge; z is the level's height.
  Point crossing(const TileEdge& edge, std::int64_t level) const;
  double value(std::int32_t vertex) const { return values_[static_cast<std::size_t>(vertex)]; }
  PointId id_of(std::int32_t vertex) const { return tile_.id_of(vertex); }
  std::uint64_t left_out() const { return left_out_; }  // main cells left out because of their edges

  // Calls give(piece) for all pieces of this tile with levels from `begin` to below `end`. Every piece belongs to one
  // tile. A piece along an edge could belong to either cell beside it, so it belongs to the tile that owns the edge.
  // Error corrupt when the tile lacks a cell beside an edge that it owns. Throws Stopped.
  template <class Give>
  Status for_each_piece(std::int64_t begin, std::int64_t end, const Give& give, const std::stop_token& stop) const {
    const auto cells = static_cast<std::int32_t>(counts_.size());
    StopCheck check(stop, cells_a_look);
    for (std::int32_t cell = 0; cell < cells; ++cell) {
      check.step();
      if (!counts_[static_cast<std::size_t>(cell)]) continue;
      const bool main = tile_.mesh().cell_ghost[static_cast<std::size_t>(cell)] == 0;
      const auto [low, high] = range(cell);
      for (std::int64_t level = std::max(low, begin); level < std::min(high, end); ++level) {
        const double height = levels_.height(level);
        const std::size_t apex = apex_of(cell, height);
        if (along_edge(cell, apex, height)) {
          BOOST_OUTCOME_TRYV(give_along(cell, apex, level, give));
        } else if (main) {
          give(across(cell, apex, level, height));
        }
      }
    }
    return success();
  }

 private:
  TileEdge edge(std::int32_t u, std::int32_t v) const {
    return tile_.id_of(u) < tile_.id_of(v) ? TileEdge{u, v} : TileEdge{v, u};
  }
  // The range of the cell's levels.
  std::pair<std::int64_t, std::int64_t> range(std::int32_t cell) const;
  // The corner that is alone above or below the level.
  std::size_t apex_of(std::int32_t cell, double height) const;
  // True if the corner is below the level and the line is the edge opposite to it.
  bool along_edge(std::int32_t cell, std::size_t apex, double height) const;
  Piece across(std::int32_t cell, std::size_t apex, std::int64_t level, double height) const;

  template <class Give>
  Status give_along(std::int32_t cell, std::size_t apex, std::int64_t level, const Give& give) const {
    // Counterclockwise, with p below the edge from q to r.
    const std::int32_t p = tile_.vertex(cell, apex), q = tile_.vertex(cell, (apex + 1) % 3),
                       r = tile_.vertex(cell, (apex + 2) % 3);
    if (std::min(tile_.owner(q), tile_.owner(r)) != tile_.id()) return success();
    const std::int32_t beyond = tile_.neighbor(cell, apex);
    if (beyond < -1 && !tile_.is_part())
      return tile_.corrupt_cell(cell, "has no neighbour across an edge that is the tile's own");
    if (beyond < 0 || !counts_[static_cast<std::size_t>(beyond)]) return success();
    std::size_t other = 0;
    while (tile_.vertex(beyond, other) == q || tile_.vertex(beyond, other) == r) ++other;
    const std::int32_t s = tile_.vertex(beyond, other);
    if (value(s) >= levels_.height(level)) {
      give(Piece{level, edge(p, r), edge(p, q)});
    } else if (tile_.id_of(p) < tile_.id_of(s)) {  // once for both cells
      // A ridge: two lines along it would coincide, so they pass its ends instead.
      give(Piece{level, edge(p, r), edge(s, r)});
      give(Piece{level, edge(s, q), edge(p, q)});
    }
    return success();
  }

  static constexpr std::uint32_t cells_a_look = 4096;

  const query::QueryTile& tile_;
  Levels levels_;
  std::vector<double> values_;  // by vertex
  std::vector<bool> counts_;    // by cell: not ignored
  std::int64_t begin_ = 0, end_ = 0;
  bool too_far_ = false;
  std::uint64_t left_out_ = 0;
};

}  // namespace tessera::terrain

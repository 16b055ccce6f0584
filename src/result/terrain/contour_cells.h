// The contour lines inside a tile's cells, as pieces.
//
// A vertex at a level counts as above it. The places of the plane that are then at or above the level are a set of
// whole cells and parts of cells, and the contour line is the border of those of them that have an area: a peak, a
// ridge and a hollow exactly at a level have no line, a flat ground at it has one where the ground falls. So no line is
// there twice, none branches, and none ends but at the hull, or at cells that do not count.
//
// As a point of a line stands for where it passes an edge from a vertex above to one below, both ends of a piece are
// such edges; at most two pieces end at one, whatever meets in a vertex.
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

// An edge by the tile's numbers of its ends, the lower source index first.
struct TileEdge {
  std::int32_t a = 0, b = 0;
  friend auto operator<=>(const TileEdge&, const TileEdge&) = default;
};

// From edge to edge, with what is above the level on the left.
struct Piece {
  std::int64_t level = 0;
  TileEdge from, to;
};

class ContourCells {
 public:
  // Cells that do not count: those that the filter leaves out, those that do not meet the box, and those that have a
  // corner without a finite value. `tile` has rows. Throws Stopped.
  ContourCells(const query::QueryTile& tile, const query::Column& column, const Levels& levels,
               const std::optional<double>& max_edge, const std::optional<Bounds>& box, const std::stop_token& stop);

  // The lowest level of a cell that counts, and one above the highest; equal when there is none.
  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return end_; }
  // Whether a value is more than Levels::number_max levels away: then there are no pieces.
  bool too_far() const { return too_far_; }
  // All pieces of all levels, of cells that are main.
  std::uint64_t pieces() const;
  // How many pieces a level has at most, from begin() on.
  std::vector<std::uint64_t> most_pieces() const;
  // Where the level passes the edge; z is its height.
  Point crossing(const TileEdge& edge, std::int64_t level) const;
  double value(std::int32_t vertex) const { return values_[static_cast<std::size_t>(vertex)]; }
  PointId id_of(std::int32_t vertex) const { return tile_.id_of(vertex); }
  std::uint64_t left_out() const { return left_out_; }  // main cells, for their edges

  // Calls give(piece) for all pieces of levels from `begin` on to below `end` that are this tile's: every piece is one
  // tile's, and either of the cells beside a piece along an edge would do, so it is the tile's that owns the edge.
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
  // The cell's levels.
  std::pair<std::int64_t, std::int64_t> range(std::int32_t cell) const;
  // The corner that is alone above or below.
  std::size_t apex_of(std::int32_t cell, double height) const;
  // Whether the corner is below, and the line the edge opposite to it.
  bool along_edge(std::int32_t cell, std::size_t apex, double height) const;
  Piece across(std::int32_t cell, std::size_t apex, std::int64_t level, double height) const;

  template <class Give>
  Status give_along(std::int32_t cell, std::size_t apex, std::int64_t level, const Give& give) const {
    // Counterclockwise, p is below the edge from q to r.
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
    } else if (tile_.id_of(p) < tile_.id_of(s)) {  // for both cells once
      // A ridge: what would go along it twice goes past its ends.
      give(Piece{level, edge(p, r), edge(s, r)});
      give(Piece{level, edge(s, q), edge(p, q)});
    }
    return success();
  }

  static constexpr std::uint32_t cells_a_look = 4096;

  const query::QueryTile& tile_;
  Levels levels_;
  std::vector<double> values_;  // by vertex
  std::vector<bool> counts_;    // by cell
  std::int64_t begin_ = 0, end_ = 0;
  bool too_far_ = false;
  std::uint64_t left_out_ = 0;
};

}  // namespace tessera::terrain

// The cells around a pixel, for natural_value.h: those of one tile, or of all tiles of a result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/column.h"
#include "src/result/query/query_tile.h"
#include "src/result/query/walker.h"
#include "src/result/terrain/natural_value.h"

namespace tessera::terrain {

inline CellCircle circle_of(const query::QueryTile& tile, std::int32_t cell) {
  std::size_t first = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (tile.id_of(tile.vertex(cell, k)) < tile.id_of(tile.vertex(cell, first))) first = k;
  const auto corner = [&](std::size_t k) -> const Point& { return tile.point(tile.vertex(cell, (first + k) % 3)); };
  return {centre_of<double>(corner(0), corner(1), corner(2)), static_cast<std::uint8_t>(first)};
}

inline Error no_neighbour(const query::QueryTile& tile, std::int32_t cell) {
  return tile.corrupt_cell(cell, "is no neighbour of the cell that says so");
}
inline Error endless(const query::QueryTile& tile, std::int32_t cell) {
  return tile.corrupt_cell(cell, "the cells around a pixel have no end here: the cells are not a triangulation");
}

// The cells of one tile. A cell that the tile does not have is unknown. The circle of a cell is computed when it is
// first asked for.
class CellsOfTile {
 public:
  using Cell = std::int32_t;

  CellsOfTile(const query::QueryTile& tile, const query::Column& column)
      : tile_(tile), circles_(tile.mesh().cell_ghost.size(), not_made()), values_(tile.mesh().points.size()) {
    for (std::size_t v = 0; v < values_.size(); ++v) values_[v] = column.value(tile.row(static_cast<std::int32_t>(v)));
  }

  const Point& point(Cell cell, std::size_t k) const { return tile_.point(tile_.vertex(cell, k)); }
  double value(Cell cell, std::size_t k) const { return values_[static_cast<std::size_t>(tile_.vertex(cell, k))]; }
  const CellCircle& circle(Cell cell) {
    CellCircle& circle = circles_[static_cast<std::size_t>(cell)];
    if (circle.first == unset) circle = circle_of(tile_, cell);
    return circle;
  }
  Beyond across(Cell cell, std::size_t k, Cell& to) const {
    to = tile_.neighbor(cell, k);
    if (to >= 0) return Beyond::cell;
    return to == -1 ? Beyond::hull : Beyond::unknown;
  }
  bool opposite(Cell cell, std::size_t /*k*/, Cell to, std::size_t& back) {
    for (back = 0; back < 3; ++back)
      if (tile_.neighbor(to, back) == cell) return true;
    error_ = no_neighbour(tile_, to);
    return false;
  }
  std::size_t cells_max() const { return circles_.size(); }
  void too_many(Cell cell) { error_ = endless(tile_, cell); }
  // What is wrong with the cells.
  const Error& error() const { return *error_; }

 private:
  static constexpr std::uint8_t unset = 3;
  static CellCircle not_made() { return {{}, unset}; }

  const query::QueryTile& tile_;
  std::vector<CellCircle> circles_;
  std::vector<double> values_;
  std::optional<Error> error_;
};

// The cells of all tiles. In a region some are unknown.
class CellsOfTiles {
 public:
  using Cell = query::CellRef;

  // `cells`: how many the result has.
  CellsOfTiles(query::Walker& walker, const query::Column& column, std::uint64_t cells)
      : walker_(walker), column_(column), cells_max_(cells) {}

  const Point& point(const Cell& cell, std::size_t k) const {
    return cell.tile->point(cell.tile->vertex(cell.cell, k));
  }
  double value(const Cell& cell, std::size_t k) const {
    return column_.value(cell.tile->row(cell.tile->vertex(cell.cell, k)));
  }
  CellCircle circle(const Cell& cell) const { return circle_of(*cell.tile, cell.cell); }
  Beyond across(const Cell& cell, std::size_t k, Cell& to) {
    walker_.forget_doubts();
    auto found = walker_.across(cell, k);
    if (!found) {
      error_ = found.error();
      return Beyond::failed;
    }
    to = found.value();
    if (to) return Beyond::cell;
    return walker_.met_unknown() ? Beyond::unknown : Beyond::hull;
  }
  bool opposite(const Cell& cell, std::size_t k, const Cell& to, std::size_t& back) {
    const PointId after = id(cell, (k + 1) % 3), last = id(cell, (k + 2) % 3);
    for (back = 0; back < 3; ++back)
      if (id(to, (back + 1) % 3) == last && id(to, (back + 2) % 3) == after) return true;
    error_ = no_neighbour(*to.tile, to.cell);
    return false;
  }
  std::size_t cells_max() const { return cells_max_; }
  void too_many(const Cell& cell) { error_ = endless(*cell.tile, cell.cell); }
  // What is wrong with the cells, or why they cannot be read.
  const Error& error() const { return *error_; }

 private:
  static PointId id(const Cell& cell, std::size_t k) { return cell.tile->id_of(cell.tile->vertex(cell.cell, k)); }

  query::Walker& walker_;
  query::Column column_;
  std::size_t cells_max_;
  std::optional<Error> error_;
};

}  // namespace tessera::terrain

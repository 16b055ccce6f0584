#include "src/result/terrain/contour_cells.h"

#include <algorithm>
#include <cmath>

#include "src/result/query/area.h"

namespace tessera::terrain {

ContourCells::ContourCells(const query::QueryTile& tile, const query::Column& column, const Levels& levels,
                           const exports::CellFilter& filter, const std::optional<Bounds>& box,
                           const std::stop_token& stop)
    : tile_(tile), levels_(levels), values_(tile.mesh().points.size()), counts_(tile.mesh().cell_ghost.size()) {
  for (std::size_t v = 0; v < values_.size(); ++v) values_[v] = column.value(tile.row(static_cast<std::int32_t>(v)));
  StopCheck check(stop, cells_a_look);
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    check.step();
    const auto cell = static_cast<std::int32_t>(i);
    std::array<Point, 3> corners;
    bool finite = true;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = tile.point(tile.vertex(cell, k));
      finite = finite && std::isfinite(value(tile.vertex(cell, k)));
    }
    if (!finite || (box && !query::meets(corners, *box))) continue;
    if (!filter.fits(tile.mesh(), i)) {
      left_out_ += tile.mesh().cell_ghost[i] == 0 ? 1 : 0;
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double z = value(tile.vertex(cell, k));
      too_far_ =
          too_far_ || !(std::abs(z) < 1e300 && std::abs(z - levels.base()) < levels.interval() * Levels::number_max);
    }
    if (too_far_) break;
    counts_[i] = true;
    const auto [low, high] = range(cell);
    if (low == high) continue;
    if (begin_ == end_) {
      begin_ = low;
      end_ = high;
    }
    begin_ = std::min(begin_, low);
    end_ = std::max(end_, high);
  }
}

std::uint64_t ContourCells::pieces() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (!counts_[i] || tile_.mesh().cell_ghost[i] != 0) continue;
    const auto [low, high] = range(static_cast<std::int32_t>(i));
    sum += static_cast<std::uint64_t>(high - low);
  }
  return sum;
}

std::vector<std::uint64_t> ContourCells::most_pieces() const {
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(end_ - begin_) + 1);
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (!counts_[i]) continue;
    const auto [low, high] = range(static_cast<std::int32_t>(i));
    if (low == high) continue;
    ++counts[static_cast<std::size_t>(low - begin_)];
    --counts[static_cast<std::size_t>(high - begin_)];
  }
  for (std::size_t k = 1; k < counts.size(); ++k) counts[k] += counts[k - 1];
  counts.pop_back();
  return counts;
}

Point ContourCells::crossing(const TileEdge& edge, std::int64_t level) const {
  const double height = levels_.height(level), at_a = value(edge.a), at_b = value(edge.b);
  const Point &a = tile_.point(edge.a), &b = tile_.point(edge.b);
  // Computed from the nearer end, so that the end itself is reproduced exactly.
  const double from_a = (height - at_a) / (at_b - at_a), from_b = (at_b - height) / (at_b - at_a);
  const auto between = [&](double u, double v) {
    const double at = from_a < from_b ? u + from_a * (v - u) : v - from_b * (v - u);
    return std::clamp(at, std::min(u, v), std::max(u, v));
  };
  return without_negative_zero({between(a.x, b.x), between(a.y, b.y), height});
}

std::pair<std::int64_t, std::int64_t> ContourCells::range(std::int32_t cell) const {
  const auto [low, high] =
      std::minmax({value(tile_.vertex(cell, 0)), value(tile_.vertex(cell, 1)), value(tile_.vertex(cell, 2))});
  return {levels_.above(low), levels_.above(high)};
}

std::size_t ContourCells::apex_of(std::int32_t cell, double height) const {
  const auto above = [&](std::size_t k) { return value(tile_.vertex(cell, k)) >= height; };
  const bool a = above(0), b = above(1), c = above(2);
  return b == c ? 0 : a == c ? 1 : 2;
}

bool ContourCells::along_edge(std::int32_t cell, std::size_t apex, double height) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const double z = value(tile_.vertex(cell, k));
    if (k == apex ? z >= height : z != height) return false;
  }
  return true;
}

Piece ContourCells::across(std::int32_t cell, std::size_t apex, std::int64_t level, double height) const {
  const std::int32_t p = tile_.vertex(cell, apex);
  const TileEdge right = edge(p, tile_.vertex(cell, (apex + 1) % 3)),
                 left = edge(p, tile_.vertex(cell, (apex + 2) % 3));
  if (value(p) >= height) return {level, right, left};
  return {level, left, right};
}

}  // namespace tessera::terrain

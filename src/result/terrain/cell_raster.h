// Finds the pixels of a cell, and the cell's values there.
//
// A cell has a pixel when it contains the pixel's centre, moved to the right by an infinitely small step, and up by one
// that is infinitely smaller still. The moved centre is on no edge. So within the hull exactly one cell has each pixel,
// whatever the order of cells and corners. In other words: a cell has centres on its left edges and on a horizontal
// lower edge, and not those on other edges; centres on the hull's right edges and on a horizontal upper edge are
// outside. Exact predicates decide.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/terrain/grid.h"

namespace tessera::terrain {

struct Corner {
  Point at;
  PointId id;
  double value = 0;
};
using Triangle = std::array<Corner, 3>;

// Returns true if the counterclockwise cell has the pixel with this centre. Exact.
bool has_pixel(const Triangle& cell, const Point& centre);

// The linear function between the corners, at a point of the closed cell. The corners' weights are not negative, and
// right to 1e-11, however thin the cell is. The sum is taken in the order of the corners.
double value_at(const Triangle& cell, const Point& q);

// Calls visit(column, row, centre) for each pixel of `grid` that the counterclockwise cell has.
template <class Visit>
void for_each_centre(const Grid& grid, const Triangle& cell, const Visit& visit) {
  // Positions in units of pixels are right to 2^-9 (pixels_max). Pixels that are nearer to an edge than this are
  // decided exactly.
  constexpr double slack = 0x1p-6;
  const double per_unit = 1 / grid.res;
  const auto [x0, x1] = std::minmax({cell[0].at.x, cell[1].at.x, cell[2].at.x});
  const auto [y0, y1] = std::minmax({cell[0].at.y, cell[1].at.y, cell[2].at.y});
  const auto place = [&](double c) { return c * per_unit - 0.5; };
  const auto first = [&](double c, std::int64_t least) {
    return std::max(static_cast<std::int64_t>(std::ceil(place(c) - slack)), least);
  };
  const auto last = [&](double c, std::int64_t most) {
    return std::min(static_cast<std::int64_t>(std::floor(place(c) + slack)), most);
  };
  const std::int64_t row_end = last(y1, grid.row0 + grid.height - 1);
  const std::int64_t left = first(x0, grid.column0), right = last(x1, grid.column0 + grid.width - 1);
  if (left > right) return;
  for (std::int64_t row = first(y0, grid.row0); row <= row_end; ++row) {
    Point centre{0, grid.centre(row), 0};
    // The interval of the line of centres that is in the cell.
    double from = std::numeric_limits<double>::infinity(), to = -from;
    bool through_corner = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point &a = cell[k].at, &b = cell[k == 2 ? 0 : k + 1].at;
      if (a.y == centre.y) {
        through_corner = true;
        from = std::min(from, a.x);
        to = std::max(to, a.x);
      } else if ((a.y < centre.y) != (b.y < centre.y)) {
        const double x = a.x + (centre.y - a.y) / (b.y - a.y) * (b.x - a.x);
        from = std::min(from, x);
        to = std::max(to, x);
      }
    }
    if (!(from <= to)) continue;
    const std::int64_t end = last(to, right);
    const double sure_from = place(from) + slack, sure_to = place(to) - slack;
    for (std::int64_t column = first(from, left); column <= end; ++column) {
      centre.x = grid.centre(column);
      const auto at = static_cast<double>(column);
      const bool sure = !through_corner && at > sure_from && at < sure_to;
      if (!sure && !has_pixel(cell, centre)) continue;
      visit(column, row, centre);
    }
  }
}

// The corners in the order of their ids.
inline Triangle by_id(Triangle cell) {
  std::sort(cell.begin(), cell.end(), [](const Corner& a, const Corner& b) { return a.id < b.id; });
  return cell;
}

// Calls put(column, row, value) for each pixel of `grid` that the counterclockwise cell has. The values do not depend
// on the order of its corners.
template <class Put>
void for_each_pixel(const Grid& grid, const Triangle& cell, const Put& put) {
  Triangle sorted;
  bool is_sorted = false;
  for_each_centre(grid, cell, [&](std::int64_t column, std::int64_t row, const Point& centre) {
    if (!is_sorted) sorted = by_id(cell);
    is_sorted = true;
    put(column, row, value_at(sorted, centre));
  });
}

// Divides the pixels of `grid` that may be in the cell into parts of at most part_side x part_side pixels. Calling
// for_each_pixel() for all parts is the same as calling it for the grid. A cell of few pixels has one part. Calls
// visit(part) until it returns an error.
inline constexpr std::int64_t part_side = 2048;
Status for_each_part_of_large(const Grid& grid, const Triangle& cell, const std::function<Status(const Grid&)>& visit);
template <class Visit>
Status for_each_part(const Grid& grid, const Triangle& cell, const Visit& visit) {
  const auto [x0, x1] = std::minmax({cell[0].at.x, cell[1].at.x, cell[2].at.x});
  const auto [y0, y1] = std::minmax({cell[0].at.y, cell[1].at.y, cell[2].at.y});
  if (std::max(x1 - x0, y1 - y0) < static_cast<double>(part_side - 4) * grid.res) return visit(grid);
  return for_each_part_of_large(grid, cell, visit);
}

}  // namespace tessera::terrain

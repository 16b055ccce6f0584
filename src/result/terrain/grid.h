// Where the pixels of a raster are.
#pragma once

#include <cstdint>
#include <string_view>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::terrain {

// Part of the one grid of pixels of a width that covers the plane: the centre of column i is at (i + 0.5) * res,
// rounded once, and so is that of row i. So the pixels of two rasters of one width are the same where both have them.
// Rows are counted upwards, lines, as in files, from the top.
struct Grid {
  double res = 1;                      // width and height of a pixel, in units of the coordinates
  std::int64_t column0 = 0, row0 = 0;  // the first column, the lowest row
  std::int64_t width = 0, height = 0;

  double centre(std::int64_t column_or_row) const { return (static_cast<double>(column_or_row) + 0.5) * res; }
  double left() const { return static_cast<double>(column0) * res; }
  double top() const { return static_cast<double>(row0 + height) * res; }
  std::int64_t line(std::int64_t row) const { return row0 + height - 1 - row; }
};

// Pixels that are so small that coordinates of the vertices tell hardly one from the next are refused: a double has 52
// bits, and one of a place this many at most.
inline constexpr double pixels_max = 0x1p40;

// All pixels that meet the inside of `box`. `vertices`: bounds of all. Error usage: a res that is not finite and above
// 0, or too small for them; an empty box; more pixels than GDAL can count. `key`: of the option that gives `res`, or a
// number of it.
Result<Grid> grid_over(double res, const Bounds& box, const Bounds& vertices, std::string_view key = "res");

}  // namespace tessera::terrain

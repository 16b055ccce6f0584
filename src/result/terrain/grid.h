// Where the pixels of a raster are.
#pragma once

#include <cstdint>
#include <string_view>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::terrain {

// A part of the one grid of pixels of width `res` that covers the plane. The centre of column i is at (i + 0.5) * res,
// rounded once, and so is that of row i. So two rasters with the same width share the pixels that both have. Rows are
// counted upwards; lines, as in files, from the top.
struct Grid {
  double res = 1;                      // width and height of a pixel, in units of the coordinates
  std::int64_t column0 = 0, row0 = 0;  // the first column, the lowest row
  std::int64_t width = 0, height = 0;

  double centre(std::int64_t column_or_row) const { return (static_cast<double>(column_or_row) + 0.5) * res; }
  double left() const { return static_cast<double>(column0) * res; }
  double top() const { return static_cast<double>(row0 + height) * res; }
  std::int64_t line(std::int64_t row) const { return row0 + height - 1 - row; }
};

// Smaller pixels are refused, because the coordinates of vertices hardly tell one from the next: a double has 52 bits,
// and a position in pixels has at most as many bits as this number.
inline constexpr double pixels_max = 0x1p40;

// Returns all pixels that meet the interior of `box`. `vertices` has the bounds of all vertices. `key` names the option
// that has `res`, or says of which option it is. Error usage: `res` is not finite, not above 0, or too small; the box
// is empty; GDAL cannot count the pixels.
Result<Grid> grid_over(double res, const Bounds& box, const Bounds& vertices, std::string_view key = "res");

}  // namespace tessera::terrain

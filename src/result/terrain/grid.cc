#include "src/result/terrain/grid.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "src/base/option.h"

namespace tessera::terrain {
namespace {

// GDAL counts columns and lines with ints. Rasters with more lines than this are of no use.
constexpr double side_max = 1 << 24;
constexpr double area_max = 0x1p40;

}  // namespace

Result<Grid> grid_over(double res, const Bounds& box, const Bounds& vertices, std::string_view key) {
  // Beyond these limits a double cannot hold the area of a pixel.
  if (!(res > 1e-100 && res < 1e100))
    return error(Errc::usage, option(key) + ": must be the width of a pixel, finite and above 0");
  if (!(box.lo.x < box.hi.x && box.lo.y < box.hi.y)) return error(Errc::usage, option("bbox") + ": has no area");
  double farthest = 0;
  for (const Bounds* bounds : {&box, &vertices})
    for (const double c : {bounds->lo.x, bounds->lo.y, bounds->hi.x, bounds->hi.y})
      farthest = std::max(farthest, std::abs(c));
  if (!(farthest <= res * pixels_max))
    return error(Errc::usage,
                 option(key) + ": is too small for coordinates as large as these, or the box is too large");
  const auto below = [&](double c) { return std::floor(c / res); };
  const auto above = [&](double c) { return std::ceil(c / res); };
  const double width = std::max(above(box.hi.x) - below(box.lo.x), 1.0);
  const double height = std::max(above(box.hi.y) - below(box.lo.y), 1.0);
  if (width > side_max || height > side_max || width * height > area_max)
    return error(Errc::usage, "a grid of " + std::to_string(static_cast<std::int64_t>(width)) + " x " +
                                  std::to_string(static_cast<std::int64_t>(height)) +
                                  " pixels is too large: give a larger " + option(key) + ", or a smaller " +
                                  option("bbox"));
  return Grid{.res = res,
              .column0 = static_cast<std::int64_t>(below(box.lo.x)),
              .row0 = static_cast<std::int64_t>(below(box.lo.y)),
              .width = static_cast<std::int64_t>(width),
              .height = static_cast<std::int64_t>(height)};
}

}  // namespace tessera::terrain

// Draws a 2D result as a raster: the heights of its surface, or another attribute of its vertices. Values between
// vertices are linear in each cell, or follow from natural neighbours.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/result/store/tile_taker.h"
#include "src/result/terrain/dem_method.h"

namespace tessera {

// The light of a hillshade: its direction in degrees clockwise from north, and its height above the horizon, up to 90.
struct Light {
  double azimuth = 315, altitude = 45;
};

// Error usage for an azimuth that is not finite, or an altitude outside (0, 90].
Status check_light(const Light& light);

struct DemOptions {
  double res = 1;                         // the width of a pixel, in units of the coordinates
  std::optional<Bounds> box = {};         // only x and y; default: the bounds of the result
  std::optional<double> max_edge = {};    // cells with a longer edge in the plane have no pixels
  std::optional<double> max_radius = {};  // and cells with a larger circumradius
  std::string value = "z";                // an attribute of the vertices; z has the heights
  DemMethod method = DemMethod::linear;
  bool doubles = false;             // pixels have 64 bits, not 32
  std::optional<Light> light = {};  // draw a hillshade of the values; they must have the unit of the coordinates
  bool overwrite = false;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // at least the memory of one tile is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // gets the fraction done, 0..1, from one thread at a time; may be null
};

struct Dem {
  std::filesystem::path path;
  std::int64_t width = 0, height = 0;  // in pixels
  std::uint64_t pixels = 0;            // with a value
  std::uint64_t left_out = 0;          // cells left out because of their edges
  std::uint64_t bytes = 0;             // of the file
  std::string note = {};               // sentences about the coordinate system and pixels without a value; else empty
};

// One line of JSON, without its end, for the command's output.
std::string to_json(const Dem& dem);

// Writes `target`, a Cloud Optimized GeoTIFF with overviews. Pixels without a cell, or with a value that is NaN, get
// the nodata value NaN. Which cell has a pixel, and the value, depends only on the triangulation: every pixel is the
// same to the last bit however the result is tiled (cell_raster.h, natural_value.h), and in rasters of different boxes
// (grid.h). Reads only tiles with cells in the box, and those of their natural neighbours; or all tiles when there is
// no box or it covers half of the result. Writes under a temporary name, beside a scratch file as large as the raster,
// and renames at the end. Errors: usage, before anything is written, for wrong options, a 3D result, a missing
// attribute or an existing target; corrupt for a damaged tile; io; interrupted.
Result<Dem> write_dem(const std::filesystem::path& out, const std::filesystem::path& target, const DemOptions& options,
                      std::stop_token stop);

// Error usage for an existing file, unless `overwrite` is set, and for a name that is not one of a GeoTIFF.
Status check_dem_target(const std::filesystem::path& target, bool overwrite);

// Draws the same pixels from tiles as a job makes them. No tile is stored or read. REQUIRES: options.method is linear,
// because natural neighbours may be in tiles that have not come.
class DemMaker final : public TileConsumer {
 public:
  // `manifest` is that of the result that the job would make, without tiles. `name` is for errors. Up to
  // options.threads threads may pass tiles. Errors: those of write_dem() before anything is written.
  static Result<std::unique_ptr<DemMaker>> begin(const std::filesystem::path& name, const Manifest& manifest,
                                                 const std::filesystem::path& target, const DemOptions& options,
                                                 const std::stop_token& stop);
  ~DemMaker() override;
  // Call this when all tiles have come.
  Result<Dem> finish();

  class Impl;

 private:
  explicit DemMaker(std::unique_ptr<Impl> impl);
  Status use(const StoredTile& cells) override;

  std::unique_ptr<Impl> impl_;
};

// Draws the same pixels from cells in memory: all main cells that have the centre of a pixel, with their rows, and
// perhaps others. Reads tiles only for another method than linear.
Result<Dem> write_dem_of(const std::filesystem::path& out, const Manifest& manifest, const StoredTile& cells,
                         const std::filesystem::path& target, const DemOptions& options, std::stop_token stop);

struct DemArray {
  std::int64_t width = 0, height = 0;  // in pixels
  double left = 0, top = 0;            // of the raster's corner; its pixels are options.res wide and high
  std::uint64_t pixels = 0;            // with a value
  std::uint64_t left_out = 0;          // cells left out because of their edges
  std::vector<double> values;          // width x height, line by line from the top; NaN where there is none
};

// Draws the same pixels in memory. Ignores options.overwrite. Without options.doubles values are rounded to 32 bits.
// Error memory for more than `pixels_max` pixels.
Result<DemArray> draw_dem(const std::filesystem::path& out, const DemOptions& options, std::uint64_t pixels_max,
                          std::stop_token stop);

}  // namespace tessera

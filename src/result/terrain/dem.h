// A 2D result as a raster: the heights of its surface, or any other value of its vertices, linear in each cell.
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

namespace tessera {

// Light on heights: the degrees from north, clockwise, from where it comes, and those above the horizon, to 90.
struct Light {
  double azimuth = 315, altitude = 45;
};

// Error usage for an azimuth that is not finite, and an altitude that is not above 0 and 90 at most.
Status check_light(const Light& light);

struct DemOptions {
  double res = 1;                       // the width of a pixel, in units of the coordinates
  std::optional<Bounds> box = {};       // x and y alone; default: the bounds of the result
  std::optional<double> max_edge = {};  // cells with a longer edge in the plane have no pixels
  std::string value = "z";              // an attribute of the vertices; z are the heights
  bool doubles = false;                 // pixels of 64 bits, not 32
  std::optional<Light> light = {};      // a hillshade of the values instead; they have the unit of the coordinates
  bool overwrite = false;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // at least that of a tile is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // is told the part that is done, 0..1, by one thread at a time; or null
};

struct Dem {
  std::filesystem::path path;
  std::int64_t width = 0, height = 0;  // in pixels
  std::uint64_t pixels = 0;            // with a value
  std::uint64_t left_out = 0;          // cells, for their edges
  std::uint64_t bytes = 0;             // of the file
  std::string note = {};               // a sentence when the coordinates have no system; else empty
};

// What the command prints: one line of JSON without its end.
std::string to_json(const Dem& dem);

// Writes `target`, a Cloud Optimized GeoTIFF with overviews; NaN, its nodata value, are pixels that no cell has, or
// whose cell has a value that is NaN. Which cell has a pixel, and its value, is a function of the triangulation alone:
// every pixel is equal to the last bit however the result is tiled (cell_raster.h), and the same in the rasters of
// different boxes (grid.h). Only tiles with cells in the box are read,
// all without one or when it covers half of the result. Written under a temporary name, beside a scratch file as large
// as the raster, and renamed at the end. Errors: usage, before anything is written, for wrong options, a 3D result, no
// such attribute, a target that exists; corrupt for a damaged tile; io; interrupted.
Result<Dem> write_dem(const std::filesystem::path& out, const std::filesystem::path& target, const DemOptions& options,
                      std::stop_token stop);

// Error usage for a file that exists, unless it is to be replaced, and for a name that is none of a GeoTIFF.
Status check_dem_target(const std::filesystem::path& target, bool overwrite);

// The same pixels, of tiles as a job makes them: none is stored, or read.
class DemMaker final : public TileConsumer {
 public:
  // `manifest`: of the result that the job would make, without tiles. `name`: what errors speak of. As many threads as
  // the options say may give tiles. Errors as of write_dem() before anything is written.
  static Result<std::unique_ptr<DemMaker>> begin(const std::filesystem::path& name, const Manifest& manifest,
                                                 const std::filesystem::path& target, const DemOptions& options,
                                                 const std::stop_token& stop);
  ~DemMaker() override;
  // When all tiles have been taken.
  Result<Dem> finish();

  class Impl;

 private:
  explicit DemMaker(std::unique_ptr<Impl> impl);
  Status use(const StoredTile& cells) override;

  std::unique_ptr<Impl> impl_;
};

// The same pixels of cells that are in memory: all main cells, with their rows, that have the centre of a pixel, others
// may be among them. No tile is read.
Result<Dem> write_dem_of(const std::filesystem::path& out, const Manifest& manifest, const StoredTile& cells,
                         const std::filesystem::path& target, const DemOptions& options, std::stop_token stop);

struct DemArray {
  std::int64_t width = 0, height = 0;  // in pixels
  double left = 0, top = 0;            // of the raster's corner; its pixels are options.res wide and high
  std::uint64_t pixels = 0;            // with a value
  std::uint64_t left_out = 0;          // cells, for their edges
  std::vector<double> values;          // width x height, by lines from the top; NaN where there is none
};

// The same pixels in memory; options.overwrite does not count, without options.doubles they are rounded to 32 bits.
// Error memory for more than `pixels_max`.
Result<DemArray> draw_dem(const std::filesystem::path& out, const DemOptions& options, std::uint64_t pixels_max,
                          std::stop_token stop);

}  // namespace tessera

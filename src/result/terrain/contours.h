// The contour lines of a 2D result: of its heights, or of any other value of its vertices, linear in each cell.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

constexpr std::int64_t index_every_max = 1'000'000;

struct ContourOptions {
  double interval = 1;                  // between levels, in units of the values
  double base = 0;                      // a level
  std::optional<Bounds> box = {};       // x and y alone: only in cells that meet it, uncut; default: all
  std::optional<double> max_edge = {};  // not in cells with a longer edge in the plane
  std::string value = "z";              // an attribute of the vertices; z are the heights
  // Of a smooth surface instead: means of this one in squares of this size (smooth_surface.h).
  std::optional<double> smooth = {};
  std::optional<double> min_length = {};  // lines that are shorter in the plane, closed or not, are left out
  std::int64_t index_every = 5;           // level base + k interval is an index line when this divides k
  bool overwrite = false;
  // Error memory for lines of more vertices, those at borders of tiles counted twice; 0: there is no bound.
  std::uint64_t vertices_max = 0;
  // Error memory for a smooth surface of more samples, of which it takes 16 in a square; 0: there is no bound.
  std::uint64_t samples_max = 0;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // at least that of a tile is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // is told the part that is done, 0..1, by one thread at a time; or null
};

struct Contours {
  std::filesystem::path path;
  std::uint64_t lines = 0, closed = 0, vertices = 0;
  std::uint64_t levels = 0;    // that have lines
  std::uint64_t left_out = 0;  // cells, for their edges
  std::uint64_t shorter = 0;   // lines left out for their length
  std::uint64_t bytes = 0;     // of the file
  std::string note = {};       // a sentence when the coordinates have no system; else empty
};

// What the command prints: one line of JSON without its end.
std::string to_json(const Contours& contours);

struct ContourCost {
  std::uint64_t points = 0;  // of lines
  std::uint64_t file_bytes = 0, scratch_bytes = 0;
};
// What the lines take, about: counted in the first tiles up to `cells_max` cells and one tile, from there on as in
// these; tiles that take more than an eighth of the memory are not looked at, and 0 is told of such alone. Errors: of
// write_contours(), but those of the target.
Result<ContourCost> estimate_contours(const std::filesystem::path& out, const ContourOptions& options,
                                      std::uint64_t cells_max, const std::stop_token& stop);

// Writes `target`, a GeoPackage (.gpkg) or GeoJSON (.geojson, .json) of lines with the attribute `elevation`, or the
// name of another value, and `index`. What a line is, exactly, stands in contour_cells.h, of a smooth surface in
// square_cells.h, their order and beginnings in contour_lines.h: the file is a function of the triangulation, however
// the result is tiled. Tiles are read once, each by itself; lines, and samples of a smooth surface, wait in files
// without a name in the target's folder. Errors: usage, before anything is written, for
// wrong options, a 3D result, no such attribute, a target that exists, an interval too small for the values; corrupt
// for a damaged tile; io; interrupted.
Result<Contours> write_contours(const std::filesystem::path& out, const std::filesystem::path& target,
                                const ContourOptions& options, std::stop_token stop);

// The same lines, in the same order, for `take`; they wait in the system's temporary folder. `options.overwrite` does
// not count.
struct ContourLine {
  double value = 0;
  bool index = false;
  std::span<const Point> points;
};
Status trace_contours(const std::filesystem::path& out, const ContourOptions& options,
                      const std::function<void(const ContourLine&)>& take, const std::stop_token& stop);

// Where the lines in a box come from: of a smooth surface also from around it. None: from everywhere.
std::optional<Bounds> source_box(const ContourOptions& options);

}  // namespace tessera

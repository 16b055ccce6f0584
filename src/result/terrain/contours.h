// The contour lines of a 2D result: of its heights, or of another attribute of its vertices, linear in each cell.
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
  double interval = 1;                    // between levels, in units of the values
  double base = 0;                        // a level
  std::optional<Bounds> box = {};         // only x and y: only in cells that meet the box, uncut; default: everywhere
  std::optional<double> max_edge = {};    // ignore cells with a longer edge in the plane
  std::optional<double> max_radius = {};  // and cells with a larger circumradius
  std::string value = "z";                // an attribute of the vertices; z has the heights
  // Lines of a smooth surface instead: means of the surface in squares of this size (smooth_surface.h).
  std::optional<double> smooth = {};
  std::optional<double> min_length = {};  // lines that are shorter in the plane are left out
  std::int64_t index_every = 5;           // level base + k interval is an index line when this divides k
  bool overwrite = false;
  // Error memory when the lines have more vertices, with those at borders of tiles counted twice; 0: no bound.
  std::uint64_t vertices_max = 0;
  // Error memory when a smooth surface needs more samples, 16 a square; 0: no bound.
  std::uint64_t samples_max = 0;
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // at least the memory of one tile is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // gets the fraction done, 0..1, from one thread at a time; may be null
};

struct Contours {
  std::filesystem::path path;
  std::uint64_t lines = 0, closed = 0, vertices = 0;
  std::uint64_t levels = 0;    // that have lines
  std::uint64_t left_out = 0;  // cells left out because of their edges
  std::uint64_t shorter = 0;   // lines left out because of their length
  std::uint64_t bytes = 0;     // of the file
  std::string note = {};       // a sentence when the coordinates have no coordinate system; else empty
};

// One line of JSON, without its end, for the command's output.
std::string to_json(const Contours& contours);

struct ContourCost {
  std::uint64_t points = 0;  // of lines
  std::uint64_t file_bytes = 0, scratch_bytes = 0;
};
// Estimates the cost of the lines: counts in the first tiles, up to `cells_max` cells and one more tile, and
// extrapolates. Tiles that need more than an eighth of the memory are skipped; if all are skipped, the estimate is 0.
// Errors: those of write_contours(), except those of the target.
Result<ContourCost> estimate_contours(const std::filesystem::path& out, const ContourOptions& options,
                                      std::uint64_t cells_max, const std::stop_token& stop);

// Writes `target`, a GeoPackage (.gpkg) or GeoJSON (.geojson, .json) of lines. Their attributes are `elevation`, or the
// name of another value, and `index`. Lines are defined in contour_cells.h (of a smooth surface: square_cells.h); their
// order and first points in contour_lines.h. So the file depends only on the triangulation, not on its tiles. Each tile
// is read once, by itself. Lines, and samples of a smooth surface, are kept in unnamed files in the target's folder.
// Errors: usage, before anything is written, for wrong options, a 3D result, a missing attribute, an existing target,
// or an interval too small for the values; corrupt for a damaged tile; io; interrupted.
Result<Contours> write_contours(const std::filesystem::path& out, const std::filesystem::path& target,
                                const ContourOptions& options, std::stop_token stop);

// Passes the same lines, in the same order, to `take`. The lines are kept in the system's temporary folder.
// `options.overwrite` is ignored.
struct ContourLine {
  double value = 0;
  bool index = false;
  std::span<const Point> points;
};
Status trace_contours(const std::filesystem::path& out, const ContourOptions& options,
                      const std::function<void(const ContourLine&)>& take, const std::stop_token& stop);

// The box from which the lines in options.box come; for a smooth surface it is larger. Nothing: everywhere.
std::optional<Bounds> source_box(const ContourOptions& options);

}  // namespace tessera

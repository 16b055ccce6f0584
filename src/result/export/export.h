// Writes a result in formats of other programs: main cells only, streamed tile by tile. docs/formats.md says what each
// format keeps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera {

struct ExportOptions {
  std::string format = {};    // one of export_format_names(); if empty, the target's ending decides
  bool heights = true;        // 2D: the attribute "z", if there is one, becomes the third coordinate
  bool spatial_index = true;  // of a GeoPackage
  // In units of the coordinates, finite and above 0. Cells with a longer edge are left out, and also the vertices that
  // no other cell has. In 2D edges are measured in the plane.
  std::optional<double> max_edge = {};
  std::optional<double> max_radius = {};  // likewise of circumradii (cell_filter.h)
  // Coordinates are relative to the lower corner of the result's box, rounded down to whole numbers, for readers with
  // 32-bit floats. Only for formats that have no place on a map: ply, obj, off, stl.
  bool local = false;
  // Formats that hold values of cells get one more column, "longest_edge", measured with heights. They also get the
  // tile, unless they have it anyway.
  bool longest_edges = false;
  // Of formats of points: which attributes and computed columns of vertices are written; empty: all. Of ndnet: the
  // first is the field, `density` without any.
  std::vector<std::string> names = {};
  // Cells that are no whole result are to be written, or the cells of a surface: formats of points are refused.
  bool cells_only = false;
  std::string comment = {};                   // ply: one line of its header
  bool overwrite = false;                     // replace existing files
  std::function<void(double)> progress = {};  // called with the fraction that is done, 0..1; may be null
};

struct Exported {
  std::filesystem::path path;  // the file or the folder
  std::uint64_t vertices = 0, cells = 0;
  std::uint64_t left_out = 0;  // cells left out because of their edges and circumradii
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;           // written, in all files together
  std::optional<Point> corner = {};  // the origin of the coordinates, if not 0, 0, 0
  std::string note = {};             // a sentence about what the format could not keep here; often empty
};

// One line of JSON, without its end, for the command's output and a job's outcome. `output` is the name of the export
// in that line.
std::string to_json(const Exported& exported, const std::string& output);

// Writes the result folder `out` to `target`. A target with an ending becomes one file, in which every vertex has one
// number. A target that is a folder, ends in '/' or has no ending becomes a folder with one file a tile (npy: one
// folder of arrays for all tiles). Files are written under temporary names and renamed at the end. Needs the memory of
// the largest tile, and 17 bytes for each vertex that tiles share. Errors: usage, before anything is read, for an
// unknown format, an existing target or a wrong option; usage for a format that cannot hold the result, and when no
// cell is left; corrupt for a damaged tile; io; interrupted.
Result<Exported> export_result(const std::filesystem::path& out, const std::filesystem::path& target,
                               const ExportOptions& options, std::stop_token stop);

// Estimates the bytes of an export of all cells; options.max_edge and options.max_radius, which
// leave some out, are ignored. Error usage for
// an unknown format.
Result<std::uint64_t> estimate_export(const Manifest& manifest, const std::filesystem::path& target,
                                      const ExportOptions& options);

// Exports cells of the result that are in memory, to one file or one folder of arrays, as export_result() does. All of
// `cells` are exported, and `cells` has no other vertices than theirs. `tiles` has the main tile of each cell. The
// points of `cells` get their heights as z, if the format wants heights. options.max_edge and
// options.max_radius are ignored.
Result<Exported> export_cells(const std::filesystem::path& out, const Manifest& manifest, StoredTile& cells,
                              std::span<const TileId> tiles, const std::filesystem::path& target,
                              const ExportOptions& options, std::stop_token stop);

struct ExportTarget {
  std::filesystem::path path;
  bool folder = false;
};
// Finds where export_result() would write. Returns those of its errors usage that need no result.
Result<ExportTarget> find_export_target(const std::filesystem::path& target, const ExportOptions& options);

// The endings of the files that an export to `target`, a single file, may make: its own ending, and that of the file
// beside it.
std::set<std::string> export_endings(const std::filesystem::path& target, const std::string& format);

std::string export_format_names();  // "ply, vtu, ..."
std::string export_format_help();   // one line a format

}  // namespace tessera

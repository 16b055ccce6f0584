// A result as files other programs read: main cells only, streamed tile by tile. docs/formats.md says what each format
// keeps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"

namespace tessera {

struct ExportOptions {
  std::string format = {};    // one of export_format_names(); empty: as the ending of the target says
  bool heights = true;        // 2D: the attribute "z", if there is one, becomes the third coordinate
  bool spatial_index = true;  // of a GeoPackage
  // In units of the coordinates, finite and above 0: cells with a longer edge are left out, and vertices that no cell
  // has then. In 2D edges are measured in the plane.
  std::optional<double> max_edge = {};
  // Coordinates count from the corner of the result's box, rounded down to whole numbers, for readers that keep floats
  // of 32 bits. Formats that nothing places on a map: ply, obj, off, stl.
  bool local = false;
  // Formats that hold values of cells get one more, "longest_edge", with the heights; and the tile, if they do not tell
  // it anyway.
  bool longest_edges = false;
  std::string comment = {};                   // ply: one line of its head
  bool overwrite = false;                     // replace files
  std::function<void(double)> progress = {};  // is told the part that is done, 0..1, now and then; or null
};

struct Exported {
  std::filesystem::path path;  // the file or folder
  std::uint64_t vertices = 0, cells = 0;
  std::uint64_t left_out = 0;  // cells, for their edges
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;           // written, all files together
  std::optional<Point> corner = {};  // that coordinates count from, if it is not 0, 0, 0
  std::string note = {};             // a sentence about what the format could not keep here; often empty
};

// What the command prints and a job's outcome holds: one line of JSON without its end. `output`: what it is called
// there.
std::string to_json(const Exported& exported, const std::string& output);

// Writes the result folder `out` to `target`. A target with an ending is one file, in which every vertex has one
// number; one that is a folder, ends in '/', or has no ending becomes a folder with a file for each tile (npy: a folder
// of arrays for all). Written under temporary names and renamed at the end. Memory is that of the largest tile plus 17
// bytes for each vertex that tiles share.
// Errors: usage, before anything is read, for an unknown format, a target that exists, or a wrong option; usage for a
// format that cannot hold the result, and when no cell is left; corrupt for a damaged tile; io; interrupted.
Result<Exported> export_result(const std::filesystem::path& out, const std::filesystem::path& target,
                               const ExportOptions& options, std::stop_token stop);

// About how many bytes the export takes, of all cells: options.max_edge, which leaves some out, does not count. Error
// usage for an unknown format.
Result<std::uint64_t> estimate_export(const Manifest& manifest, const std::filesystem::path& target,
                                      const ExportOptions& options);

// As export_result() with some cells of the result that are in memory: all of `cells`, whose vertices they have, of the
// main tiles `tiles`, in their order, to one file or one folder of arrays. Lifts the points of `cells` to their heights
// if the format wants it. max_edge does not count.
Result<Exported> export_cells(const std::filesystem::path& out, const Manifest& manifest, StoredTile& cells,
                              std::span<const TileId> tiles, const std::filesystem::path& target,
                              const ExportOptions& options, std::stop_token stop);

struct ExportTarget {
  std::filesystem::path path;
  bool folder = false;
};
// Where export_result() would write to. Its errors that need no result: usage.
Result<ExportTarget> find_export_target(const std::filesystem::path& target, const ExportOptions& options);

// Of the files that an export to `target` may make, which is one file: its own ending, and that of what stands beside
// it.
std::set<std::string> export_endings(const std::filesystem::path& target, const std::string& format);

std::string export_format_names();  // "ply, vtu, ..."
std::string export_format_help();   // a line for each

}  // namespace tessera

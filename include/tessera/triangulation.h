// Triangulations of any size: spread over tiles in a result folder, of which only what is looked at is in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "tessera/failure.h"
#include "tessera/visibility.h"

namespace tessera {

// How far a job is.
struct JobProgress {
  std::string phase;  // "planning", "routing", "triangulating", "splaying", "collecting", "finishing", "done"
  std::uint64_t points_total = 0;  // 0 while unknown
  std::uint64_t points_routed = 0, points_triangulated = 0;
  std::uint32_t tiles_total = 0, tiles_triangulated = 0, tiles_stored = 0;
  double seconds = 0;  // since the job began
};

struct TriangulationOptions {
  // 2 or 3; 0, for files only: 2 when no file holds z.
  int dimension = 3;
  // The result folder, which stays. Empty: a temporary folder under std::filesystem::temp_directory_path(), removed
  // with the last copy of the Triangulation.
  std::filesystem::path folder = {};
  bool overwrite = false;                    // an earlier result in `folder`
  std::uint64_t max_points_per_tile = 0;     // 0: chosen from memory and threads
  std::uint32_t threads = 0;                 // 0: all that this process may use
  std::uint64_t memory_bytes = 0;            // 0: 70 % of what is free
  bool neighbors = true;                     // keep the neighbours of cells
  bool skip_invalid = false;                 // leave points with NaN or infinite coordinates out, do not fail
  bool recursive = false;                    // take the files in subfolders of folders, too
  std::vector<std::string> attributes = {};  // of the points, from files; "all" for all there are
  // Called some ten times a second, and once at the end, in the thread that called triangulate(). An exception ends the
  // job, and comes out of triangulate(). Of an unfinished job nothing stays in the folder.
  std::function<void(const JobProgress&)> progress = {};
  std::stop_token stop = {};
};

// How a result is written for other programs.
struct ExportRequest {
  std::string format = {};  // "ply", "vtu", "gpkg", ... (docs/formats.md); empty: as the ending of the target says
  bool heights = true;      // 2D: the attribute "z", if there is one, becomes the third coordinate
  bool overwrite = false;   // replace files of the same names
  // Told now and then which part is done, 0 to 1, in the thread that called. An exception ends the work, and comes out.
  std::function<void(double)> progress = {};
  std::stop_token stop = {};
};

// One tile: the cells with a vertex of its own. Arrays live as long as the Tile or a copy of it; a loop over
// `t.tile(i).cells()` would outlive both: name the tile first.
class TESSERA_PUBLIC Tile {
 public:
  struct Field {
    std::string name;
    std::string type;                   // NumPy's name: "uint8", "int16", "float64", ...
    std::span<const std::byte> values;  // n values of that type
  };

  std::uint32_t id() const;
  int dimension() const;
  // n x 3; in 2D z is 0.
  std::span<const double> points() const;
  // n: the rank of each point in the whole input.
  std::span<const std::uint64_t> ids() const;
  // n: 1 for a vertex that another tile owns.
  std::span<const std::uint8_t> foreign() const;
  // m x (dimension+1) indices into points; positively oriented.
  std::span<const std::int32_t> cells() const;
  // m: 1 for a cell that is main in another tile. The cells with 0, over all tiles, are the triangulation, each once.
  std::span<const std::uint8_t> ghost() const;
  // m x (dimension+1): the cell of this tile across the facet opposite each vertex, -1 outside, -2 a cell that only
  // other tiles hold (when no vertex of the facet is the tile's own, it may also be outside). Empty when not kept.
  std::span<const std::int32_t> neighbors() const;
  const std::vector<Field>& attributes() const;

 private:
  friend class Triangulation;
  struct Impl;
  explicit Tile(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// A finished result. Cheap to copy: copies share the folder.
class TESSERA_PUBLIC Triangulation {
 public:
  // A result folder that is there. Failure: io, corrupt.
  static Triangulation open(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const;
  int dimension() const;
  std::uint64_t vertices() const;
  std::uint64_t cells() const;
  std::uint64_t points_read() const;
  std::uint64_t duplicates() const;
  // 32 hexadecimal digits: the same for two results if and only if they are the same triangulation of the same points
  // in the same order, whatever their tiles (but for a chance of 2^-128). "" for results of software that made none.
  std::string digest() const;
  // Of the tiles that have points: 0 to tiles()-1 below.
  std::size_t tiles() const;
  // Reads one from disk. Failure: usage for no such tile, io, corrupt. Safe to call at once from several threads.
  Tile tile(std::size_t index) const;
  std::string crs() const;
  // Writes the cells, each once, to `target`: with an ending it is one file, else a folder with a file for each tile.
  // Whole or not at all. Returns a sentence about what the format could not keep here, often "". Failure: usage for
  // what the format cannot hold and for a target that exists, corrupt, io, interrupted.
  std::string export_to(const std::filesystem::path& target, const ExportRequest& request = {}) const;

 private:
  friend struct TriangulationMaker;
  struct Impl;
  explicit Triangulation(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// `coordinates`: n x dimension, row after row, read while this runs. Failure: any cause.
TESSERA_PUBLIC Triangulation triangulate(std::span<const double> coordinates, const TriangulationOptions& options = {});
// `inputs`: files, folders and patterns, as the command takes them.
TESSERA_PUBLIC Triangulation triangulate(const std::vector<std::string>& inputs,
                                         const TriangulationOptions& options = {});

}  // namespace tessera

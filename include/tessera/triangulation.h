// Triangulations of any size: spread over tiles in a result folder, of which only what is looked at is in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tessera/failure.h"
#include "tessera/options.h"
#include "tessera/visibility.h"

namespace tessera {

// One tile: the cells with a vertex of its own. Arrays live as long as the Tile or a copy of it; a loop over
// `t.tile(i).cells()` would outlive both: name the tile first.
class TESSERA_PUBLIC Tile {
 public:
  // Programs have its size compiled in: it stays as it is.
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
  // Of vertices; columns of vertices are among them.
  const std::vector<Field>& attributes() const;
  // Columns of cells: m values each.
  const std::vector<Field>& cell_columns() const;

 private:
  friend struct TileMaker;
  struct Impl;
  explicit Tile(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// That a result is the Delaunay triangulation of its points: what was compared, and counted meanwhile.
class TESSERA_PUBLIC Proof {
 public:
  std::uint64_t cells() const;
  std::uint64_t facets() const;
  std::uint64_t hull_facets() const;
  std::uint64_t vertices() const;
  // A line for each check that was passed.
  const std::vector<std::string>& checks() const;

 private:
  friend class Triangulation;
  struct Impl;
  explicit Proof(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// What was computed of a result and added to it. Programs have its size compiled in: it stays as it is.
struct ColumnInfo {
  std::string name;
  bool of_cells = false;      // else of vertices, and among the attributes of tiles
  std::string type;           // NumPy's name
  std::string unit;           // "metre^3"; "" when nobody knows
  std::uint32_t version = 0;  // of the result, that it came with
};

// Programs have its size compiled in: it stays as it is.
struct MeasureReport {
  double total = 0;  // over all cells, rounded once: a function of the triangulation alone
  std::string unit;  // "metre^3"; "" when nobody knows
  bool made = true;  // else the columns were there already
  std::string note;  // what there is to say about the values; else ""
};

// A finished result, of one version of it: a change by another program is seen when it is opened again. Cheap to copy:
// copies share the folder.
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
  // In 2D those of them whose height is not that of the vertex; nothing when heights are not known.
  std::optional<std::uint64_t> duplicates_at_other_heights() const;
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
  // Proves it from its files, however it was made. Failure: not_delaunay with the first violation (tile, cell,
  // vertices); corrupt for damaged files and for a manifest they do not belong to; io, memory, interrupted.
  Proof verify(const VerifyRequest& request = {}) const;
  // What was computed of it so far.
  std::vector<ColumnInfo> columns() const;
  // Computes columns and adds them to the folder, as a new version of the result, which this object is from then on;
  // copies of it stay at the old one. Failure: usage when nothing is asked for, or another program changes the folder;
  // corrupt, io, memory, interrupted.
  MeasureReport measure(const MeasureRequest& request);
  // What `tessera info --json` says of it, one JSON object.
  std::string describe() const;

 private:
  friend struct TriangulationMaker;
  struct Impl;
  explicit Triangulation(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// `coordinates`: n x dimension, row after row, read while this runs. Failure: any cause.
TESSERA_PUBLIC Triangulation triangulate(std::span<const double> coordinates, const TriangulationOptions& options = {});
// Rows of named columns in a program's memory, as NumPy has them in a structured array.
//
// Programs have its size compiled in: it stays as it is.
struct Records {
  std::span<const std::byte> bytes;
  std::uint64_t rows = 0;
  // "[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('intensity', '<u2')]": names and types, in the order in memory. x, y
  // and z are the coordinates, the others attributes: TriangulationOptions::attributes() says which are kept.
  std::string columns;
};

// As a .npy file of these rows, read while this runs; TriangulationOptions::dimension() 2 takes z for heights.
TESSERA_PUBLIC Triangulation triangulate(const Records& records, const TriangulationOptions& options = {});
// `inputs`: files, folders and patterns, as the command takes them.
TESSERA_PUBLIC Triangulation triangulate(const std::vector<std::string>& inputs,
                                         const TriangulationOptions& options = {});
// The checksum of a file as manifests have it: XXH3 of 64 bits, in 16 lower-case hexadecimal digits. Those of tiles and
// duplicates are `in_pieces` from format 3 on. Failure: io.
TESSERA_PUBLIC std::string file_checksum(const std::filesystem::path& file, bool in_pieces = false);
// What is in these inputs, and what it would take to triangulate them so, or what one result folder is: what
// `tessera info --json` says, one JSON object. Reads headers and a sample. Failure: as of triangulate().
TESSERA_PUBLIC std::string describe(const std::vector<std::string>& inputs, const TriangulationOptions& options = {});

}  // namespace tessera

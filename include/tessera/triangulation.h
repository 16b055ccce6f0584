// Triangulations of any size. A triangulation is spread over the tiles of a result folder, and a program reads one tile
// at a time into memory. docs/glossary.md explains the words.
#pragma once

#include <array>
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

// One tile of a result, in memory: all cells that have a vertex which the tile owns, with their n vertices. The arrays
// live as long as the Tile or a copy of it. So name the tile before a loop: in `for (auto v : t.tile(i).cells())` the
// tile would end before the loop does.
class TESSERA_PUBLIC Tile {
 public:
  // Programs are compiled with the size of this struct, so it never changes.
  struct Field {
    std::string name;
    std::string type;                   // the type's name in NumPy: "uint8", "int16", "float64", ...
    std::span<const std::byte> values;  // values of that type, one for each vertex or cell
  };

  std::uint32_t id() const;
  int dimension() const;
  // The coordinates of the vertices. Shape: n x 3; in 2D z is 0.
  std::span<const double> points() const;
  // n: the source index of each vertex, which is its rank in the whole input, counted from 0.
  std::span<const std::uint64_t> ids() const;
  // n: 1 for a vertex that another tile owns, else 0. In a periodic result also 1 for an image of a vertex.
  std::span<const std::uint8_t> foreign() const;
  // Shape: n x 3. How many periods each vertex lies away from the point of the same source index in the box, by axis:
  // -1, 0 or 1. points() has the coordinates of the image. Empty if no vertex of the tile is an image.
  std::span<const std::int8_t> offsets() const;
  // The vertices of the m cells, as indices into points(). Shape: m x (dimension+1). Cells are positively oriented.
  std::span<const std::int32_t> cells() const;
  // m: 1 for a cell that is counted in another tile, else 0. The cells with 0, over all tiles, are the triangulation,
  // each cell once.
  std::span<const std::uint8_t> ghost() const;
  // For each vertex of a cell, the cell of this tile across the opposite facet; -1 if the facet is on the hull; -2 if
  // only other tiles hold that cell. (-2 may also stand for a facet on the hull, if the tile owns none of the facet's
  // vertices.) Shape: m x (dimension+1). Empty if the result was made without neighbours.
  std::span<const std::int32_t> neighbors() const;
  // The attributes of the vertices, n values each. Columns of vertices are among them.
  const std::vector<Field>& attributes() const;
  // The columns of cells, m values each.
  const std::vector<Field>& cell_columns() const;

 private:
  friend struct TileMaker;
  struct Impl;
  explicit Tile(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// The outcome of a proof that a result is the Delaunay triangulation of its points: what was counted and checked.
class TESSERA_PUBLIC Proof {
 public:
  std::uint64_t cells() const;
  std::uint64_t facets() const;
  std::uint64_t hull_facets() const;
  std::uint64_t vertices() const;
  // One line for each check that the result has passed.
  const std::vector<std::string>& checks() const;

 private:
  friend class Triangulation;
  struct Impl;
  explicit Proof(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// A column: an array that was computed from a result and added to it. Programs are compiled with the size of this
// struct, so it never changes.
struct ColumnInfo {
  std::string name;
  bool of_cells = false;      // true: a column of cells; false: of vertices, and among the attributes of tiles
  std::string type;           // the type's name in NumPy
  std::string unit;           // for example "metre^3"; "" if the unit is not known
  std::uint32_t version = 0;  // the version of the result that brought the column
};

// The outcome of Triangulation::measure(). Programs are compiled with the size of this struct, so it never changes.
struct MeasureReport {
  // The sum of the volumes of all cells, rounded once, if volumes were asked for. It depends on the triangulation
  // alone.
  double total = 0;
  std::string unit;  // for example "metre^3"; "" if the unit is not known
  bool made = true;  // false: the result had the columns already
  std::string note;  // a sentence about the values, or ""
};

class VoidsRequest;
struct FoundVoids;

// One version of a finished result. If another program changes the result, open the folder again to see the change.
// Copies are cheap and share the folder. Const functions may be called from several threads at once.
class TESSERA_PUBLIC Triangulation {
 public:
  // Opens an existing result folder. Failure: io, corrupt.
  static Triangulation open(const std::filesystem::path& folder);
  // Opens an older version of it, or the newest, by its number. Failure also: usage, with the versions that can be
  // read, when this one cannot. Such a triangulation cannot be measured.
  static Triangulation open(const std::filesystem::path& folder, std::uint32_t version);

  // Of a triangulation that was opened by the number of its version: a path that stands for this version.
  const std::filesystem::path& folder() const;
  int dimension() const;
  std::uint64_t vertices() const;
  std::uint64_t cells() const;
  std::uint64_t points_read() const;
  std::uint64_t duplicates() const;
  // 2D: the number of duplicates whose height is not that of the vertex; no value if heights are not known.
  std::optional<std::uint64_t> duplicates_at_other_heights() const;
  // 32 hexadecimal digits. Two results have the same digest if and only if they are the same triangulation of the same
  // points in the same order, whatever their tiles are (wrong with a probability of 2^-128). "" for results of software
  // that made no digest.
  std::string digest() const;
  // The period along x, y and z; 0 along an axis without one.
  std::array<double, 3> period() const;
  // The number of tiles that have points. tile() counts them from 0.
  std::size_t tiles() const;
  // Reads a tile from disk. Failure: usage if `index` is not below tiles(); io, corrupt.
  Tile tile(std::size_t index) const;
  // The coordinate system: WKT, "EPSG:n", or "" if it is not known.
  std::string crs() const;
  // Writes the cells, each once, to `target`: to one file if `target` has an ending, else to a folder with a file for
  // each tile. The export is written whole or not at all. Returns a sentence about what the format could not keep, or
  // "". Failure: usage for a result that the format cannot hold and for a target that exists; corrupt, io, interrupted.
  std::string export_to(const std::filesystem::path& target, const ExportRequest& request = {}) const;
  // Proves from the files that the result is right, independently of how it was made. Failure: not_delaunay with the
  // first violation (tile, cell, vertices); corrupt for damaged files, and for files that do not belong to the
  // manifest; usage for a region; io, memory, interrupted.
  Proof verify(const VerifyRequest& request = {}) const;
  // The columns of this version.
  std::vector<ColumnInfo> columns() const;
  // Computes columns and adds them to the folder, as a new version of the result. This object becomes the new version;
  // its copies stay at the old version. Failure: usage when the request asks for nothing, and when another program is
  // changing the folder; corrupt, io, memory, interrupted.
  MeasureReport measure(const MeasureRequest& request);
  // Finds voids (voids.h, which has the two types), computes the columns that this needs, and adds the column of zones
  // to the folder, as a new version of the result, unless the result has it. This object becomes the new version.
  // Failure: as of measure(); also usage for another density, a target that exists, and a region; bad_input for a
  // density that is negative.
  FoundVoids find_voids(const VoidsRequest& request);
  // Returns one JSON object, the output of `tessera info --json`.
  std::string describe() const;

 private:
  friend struct TriangulationMaker;
  struct Impl;
  explicit Triangulation(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

// Triangulates points in memory. Shape of `coordinates`: n x dimension, row after row; dimension is that of the
// options. The array must not change while the function runs. Failure: any cause but not_delaunay.
TESSERA_PUBLIC Triangulation triangulate(std::span<const double> coordinates, const TriangulationOptions& options = {});
// Rows of named columns in memory, like a structured array of NumPy. Programs are compiled with the size of this
// struct, so it never changes.
struct Records {
  std::span<const std::byte> bytes;
  std::uint64_t rows = 0;
  // The names and types of the columns, in the order in memory, for example
  // "[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('intensity', '<u2')]". x, y and z are the coordinates. All others are
  // attributes; TriangulationOptions::attributes() says which of them are kept.
  std::string columns;
};

// Triangulates rows in memory, as it would triangulate a .npy file of these rows. With dimension 2, z is the height.
// The rows must not change while the function runs. Failure: as above.
TESSERA_PUBLIC Triangulation triangulate(const Records& records, const TriangulationOptions& options = {});
// Triangulates files. `inputs`: files, folders and patterns, as the command takes them. Failure: as above.
TESSERA_PUBLIC Triangulation triangulate(const std::vector<std::string>& inputs,
                                         const TriangulationOptions& options = {});
// Returns the checksum of a file as it stands in manifests: XXH3 of 64 bits, as 16 lower-case hexadecimal digits. From
// format 3 on the checksums of tiles and duplicates are those with `in_pieces`. Failure: io.
TESSERA_PUBLIC std::string file_checksum(const std::filesystem::path& file, bool in_pieces = false);
// Returns one JSON object, the output of `tessera info --json`: what is in these inputs and what triangulating them
// with these options would take, or what a result folder is. Reads only headers and a sample of the points. Failure: as
// of triangulate().
TESSERA_PUBLIC std::string describe(const std::vector<std::string>& inputs, const TriangulationOptions& options = {});

}  // namespace tessera

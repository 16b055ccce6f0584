// Questions to a result folder, answered exactly, from as little of it as an answer needs.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/area.h"
#include "src/result/query/query_tile.h"

namespace tessera::query {

struct OpenOptions {
  // Of tiles in memory. At least what a question needs at once is held, a tile a thread, and its neighbours in turn.
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  // Also results that are parts of a triangulation: who asks looks at `final` in each answer.
  bool parts = false;
};

// What all questions about many things have in common.
struct AskOptions {
  unsigned threads = 1;
  std::stop_token stop = {};
};

// A cell of the triangulation.
struct Cell {
  TileId tile;             // its main tile
  std::int32_t cell = -1;  // its place in that tile's file; -1: there is none, the point is outside the hull
  std::array<PointId, 4> vertices{no_id, no_id, no_id, no_id};  // as in the file: positively oriented
  bool final = true;  // so it is in the whole triangulation, and if there is none, too
  explicit operator bool() const { return cell >= 0; }
  friend bool operator==(const Cell&, const Cell&) = default;
};

struct Vertex {
  PointId id;
  TileId owner;
  Point at;
};

// All of a cell.
struct CellDetails {
  Cell cell;
  std::vector<Vertex> vertices;
  // Across the facet opposite each vertex; none: the facet is on the hull, or, not final, no cell is known there.
  std::vector<Cell> neighbors;
};

// All around a vertex.
struct Star {
  Vertex vertex;
  std::vector<Cell> cells;
  std::vector<Vertex> neighbors;  // by id
  // Of its Voronoi cell, in 2D the area, rounded. Infinite when the vertex is on the hull, NaN
  // when a cell around it has no volume, as only damaged ones have.
  double voronoi_volume = 0;
  bool final = true;  // these are all cells around it, and of the whole triangulation; else the volume may be NaN
};

struct CellLimits {
  std::uint64_t bytes_max = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t cells_max = std::numeric_limits<std::uint64_t>::max();
};

// Cells with the vertices they have, in memory. All are flagged as main and their vertices as own; neighbours are -1
// where there is none in the set.
struct CellSet {
  StoredTile mesh;
  std::vector<TileId> tiles;         // by cell: its main tile
  std::vector<std::int32_t> places;  // by cell: its place in that tile's file
  bool final = true;                 // these are all cells of the whole triangulation there, and no others
};

// The cells with a facet on the hull, or on the border of those without long edges.
struct HullCells {
  CellSet set;
  std::vector<std::uint8_t> facets;  // by cell, bit k: the facet opposite its vertex k is on it
  // Of the longest edges of all cells of the result: p % are not longer than lengths[p], which is rounded up, by 3 % at
  // most. 101 of them, or none when there are no cells.
  std::vector<double> lengths;
};

enum class Method : std::uint8_t {
  linear,   // barycentric in the cell that has the point
  natural,  // Sibson's natural neighbours; linear on facets of the hull and where rounding spoils them
};

struct InterpolateOptions {
  std::string value;  // an attribute of the vertices; "z" of a 2D result are the heights
  Method method = Method::linear;
  bool weights = false;
};

// Of one point. The value is NaN outside the hull.
struct Interpolated {
  double value = 0;
  bool final = true;              // so it is in the whole triangulation; else it may be NaN because too little is known
  std::vector<PointId> vertices;  // if weights were asked for: which vertices,
  std::vector<double> weights;    // and how much of each; they add up to 1
};

// For several threads at once. Nothing of it is believed but what the files' checksums say: a damaged file gives an
// error of Errc::corrupt that names it.
class StoredTriangulation {
 public:
  // Reads the manifest alone. Errors: those of read_manifest(); corrupt for a partition that is none; usage for
  // a region of a triangulation, whose cells end where the triangulation does not, if parts are not wanted.
  static Result<StoredTriangulation> open(const std::filesystem::path& out, const OpenOptions& options = {});
  static Result<StoredTriangulation> open(TileSource source, const OpenOptions& options = {});
  StoredTriangulation(StoredTriangulation&&) noexcept;
  ~StoredTriangulation();

  const TileSource& source() const;
  const Manifest& manifest() const;  // of the source
  // Whether all cells of the whole triangulation that meet the closed box are here: of a part it may be so, or not.
  bool knows(const Bounds& box) const;
  std::uint64_t tiles_read() const;  // so far, one as often as it was

  // The cell that has each point, boundaries included: of several the one whose sorted vertices come first, so that the
  // answer does not depend on tiles. Exact, for every partition. REQUIRES: points are finite, in 2D with z = 0.
  Result<std::vector<Cell>> locate(std::span<const Point> points, const AskOptions& options) const;
  // REQUIRES: it is a cell that locate(), star() or cell() gave.
  Result<CellDetails> details(const Cell& cell) const;

  // Error usage when no vertex has this index. A duplicate stands for the vertex that was kept. `owner`: the tile of
  // the vertex, if it is known; else tiles are read until it is found.
  Result<Star> star(PointId id, std::optional<TileId> owner, const AskOptions& options) const;

  // The cells that meet the closed area, each once. Error memory when they need more than the limits, as soon as that
  // is known; usage for a plane and a 2D result.
  Result<CellSet> cells(const Area& area, const CellLimits& limits, const AskOptions& options) const;

  // The cells that are on the hull, by tile; all tiles are read. With `max_edge` cells with a longer edge are left out,
  // and it is the border of the others. Errors as of cells().
  Result<HullCells> hull(const CellLimits& limits, const AskOptions& options,
                         std::optional<double> max_edge = {}) const;

  // A cell by its main tile and its place in that tile's file. Error usage when there is none, or it is main elsewhere.
  Result<Cell> cell(TileId tile, std::int32_t place) const;

  // The tiles that own a vertex of a cell that meets the closed area, ascending: with them one has those cells, and
  // their neighbours across edges that meet it.
  Result<std::vector<TileId>> tiles(const Area& area, const AskOptions& options) const;

  // One answer a point. Errors as above; usage when there is no such attribute.
  Result<std::vector<Interpolated>> interpolate(std::span<const Point> points, const InterpolateOptions& what,
                                                const AskOptions& options) const;

 private:
  struct Impl;
  explicit StoredTriangulation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::query

// Answers queries to a result folder exactly, and reads only what an answer needs.
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

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/area.h"
#include "src/result/query/query_tile.h"

namespace tessera::query {

struct OpenedResult;

struct OpenOptions {
  // For tiles in memory. A query keeps at least what it needs at once: a tile a thread, and its neighbours in turn.
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  // Also open regions. The caller must then look at `final` in each answer.
  bool parts = false;
  // Also open periodic results. They answer locate(), details(), star(), neighbours() and interpolate() by the linear
  // method; other questions are refused.
  Periods periods = Periods::refused;
};

// Options of all queries for many things.
struct AskOptions {
  unsigned threads = 1;
  std::stop_token stop = {};
};

// A cell of the triangulation.
struct Cell {
  TileId tile;             // its main tile
  std::int32_t cell = -1;  // its index in that tile's file; -1: there is no cell, the point is outside the hull
  std::array<PointId, 4> vertices{no_id, no_id, no_id, no_id};  // in the file's order: positively oriented
  bool final = true;  // the answer, also that there is no cell, holds in the whole triangulation
  explicit operator bool() const { return cell >= 0; }
  friend bool operator==(const Cell&, const Cell&) = default;
};

struct Vertex {
  PointId id;
  TileId owner;
  Point at;                  // of the image that is meant
  PeriodOffset offset = {};  // how many periods the image lies away from the point
};

// A cell with its vertices and neighbours.
struct CellDetails {
  Cell cell;
  std::vector<Vertex> vertices;
  // Across the facet opposite each vertex. No cell: the facet is on the hull, or, if not final, the cell there is
  // unknown.
  std::vector<Cell> neighbors;
};

// A vertex with its cells and neighbours.
struct Star {
  Vertex vertex;
  std::vector<Cell> cells;        // a cell with several images of the vertex comes several times
  std::vector<Vertex> neighbors;  // by id; images of one point by offset
  // The volume of its Voronoi cell, in 2D the area, rounded. Infinite when the vertex is on the hull; NaN when a cell
  // around the vertex has no volume, which only damaged results have.
  double voronoi_volume = 0;
  bool final = true;  // these are exactly the cells around it in the whole triangulation; else the volume may be NaN
};

// The vertices that share an edge with a vertex.
struct Neighbours {
  PointId asked;             // the source index of the question
  PointId vertex;            // for a duplicate the kept point; else the same
  std::vector<PointId> ids;  // source indices, ascending; each once, and without the vertex itself
  bool on_hull = false;
  bool final = true;  // these are all neighbours in the whole triangulation, too
};

struct CellLimits {
  std::uint64_t bytes_max = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t cells_max = std::numeric_limits<std::uint64_t>::max();
};

// Cells with their vertices, in memory. All cells are flagged as main, and all vertices as own. A neighbour is -1 when
// the set does not have it.
struct CellSet {
  StoredTile mesh;
  std::vector<TileId> tiles;         // by cell: its main tile
  std::vector<std::int32_t> places;  // by cell: its index in that tile's file
  bool final = true;                 // these are exactly the cells of the whole triangulation there
};

// The cells with a facet on the hull, or, without long edges, on the border of the remaining cells.
struct HullCells {
  CellSet set;
  std::vector<std::uint8_t> facets;  // by cell, bit k: the facet opposite its vertex k is on the hull
  // The distribution of the cells' longest edges: in p % of all cells of the result, the longest edge is at most
  // lengths[p], which is rounded up by 3 % at most. 101 numbers, or none when there are no cells.
  std::vector<double> lengths;
};

enum class Method : std::uint8_t {
  linear,   // barycentric in the cell that contains the point
  natural,  // Sibson's natural neighbours; linear on facets of the hull and where rounding spoils them
};

struct InterpolateOptions {
  std::string value;  // an attribute of the vertices; "z" has the heights of a 2D result
  Method method = Method::linear;
  bool weights = false;
};

// The answer for one point. The value is NaN outside the hull.
struct Interpolated {
  double value = 0;
  bool final = true;              // holds in the whole triangulation; if not, the value may be NaN
  std::vector<PointId> vertices;  // if weights were asked for: the vertices,
  std::vector<double> weights;    // and their weights, which add up to 1
};

// Thread-safe. Files are trusted only as far as their checksums go: a damaged file gives an error Errc::corrupt with
// its name.
class StoredTriangulation {
 public:
  // Reads only the manifest. Errors: those of read_manifest(); corrupt for a damaged partition; usage for a region,
  // whose cells end where the triangulation does not, unless options.parts is set.
  static Result<StoredTriangulation> open(const std::filesystem::path& out, const OpenOptions& options = {});
  static Result<StoredTriangulation> open(TileSource source, const OpenOptions& options = {});
  StoredTriangulation(StoredTriangulation&&) noexcept;
  ~StoredTriangulation();

  const TileSource& source() const;
  const Manifest& manifest() const;  // of the source
  // Returns true if all cells of the whole triangulation that meet the closed box are here. For a region that depends
  // on the box.
  bool knows(const Bounds& box) const;
  std::uint64_t tiles_read() const;  // so far; a tile counts each time

  // The cell that contains each point, boundaries included. When several cells contain it, the one whose sorted
  // vertices come first, so the answer does not depend on tiles. Exact for every partition. REQUIRES: points are
  // finite; z = 0 in 2D.
  Result<std::vector<Cell>> locate(std::span<const Point> points, const AskOptions& options) const;
  // REQUIRES: locate(), star() or cell() returned the cell.
  Result<CellDetails> details(const Cell& cell) const;

  // The star of a vertex. For a duplicate, the star of the kept point. `owner` is the tile of the vertex, if it is
  // known; else tiles are read until the vertex is found. Error usage when no vertex has this index.
  Result<Star> star(PointId id, std::optional<TileId> owner, const AskOptions& options) const;
  // The neighbours of a vertex, likewise. Reads only the tile that owns the vertex.
  Result<Neighbours> neighbours(PointId id, std::optional<TileId> owner, const AskOptions& options) const;

  // The cells that meet the closed area, each once. Errors: memory when they exceed the limits, as soon as that is
  // known; usage for a plane and a 2D result.
  Result<CellSet> cells(const Area& area, const CellLimits& limits, const AskOptions& options) const;

  // The cells on the hull, by tile. Reads all tiles. Cells with a longer edge than `max_edge` or a larger circumradius
  // than `max_radius` are left out, and the border of the other cells counts as hull. Errors: as cells().
  Result<HullCells> hull(const CellLimits& limits, const AskOptions& options, std::optional<double> max_edge = {},
                         std::optional<double> max_radius = {}) const;

  // A cell by its main tile and its index in that tile's file. Error usage when there is no such cell, or when it is
  // main in another tile.
  Result<Cell> cell(TileId tile, std::int32_t place) const;

  // The tiles that own a vertex of a cell that meets the closed area, ascending. These tiles have all such cells, and
  // their neighbours across edges that meet the area.
  Result<std::vector<TileId>> tiles(const Area& area, const AskOptions& options) const;

  // One answer for each point. Errors: as locate(); usage when there is no such attribute.
  Result<std::vector<Interpolated>> interpolate(std::span<const Point> points, const InterpolateOptions& what,
                                                const AskOptions& options) const;

 private:
  explicit StoredTriangulation(std::unique_ptr<OpenedResult> result);
  std::unique_ptr<OpenedResult> result_;
};

}  // namespace tessera::query

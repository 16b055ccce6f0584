// Questions to a finished result: which cell has a point, what is around a vertex, which cells meet a box or polygons,
// and values between the vertices. Exact, and from as few tiles as an answer needs (docs/queries.md).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

// Of n points, with d dimensions; -1 in all of them for a point outside the hull. Programs have the sizes of this
// struct and of those below compiled in: they stay as they are.
struct Located {
  std::vector<std::int64_t> tiles;     // n: the main tile of the cell, its Tile::id()
  std::vector<std::int64_t> cells;     // n: the cell's place in that tile's cells()
  std::vector<std::int64_t> vertices;  // n x (d+1): the ranks of its vertices in the input, positively oriented
};

struct Star {
  std::uint64_t vertex = 0;  // of equal points the one that was kept
  std::uint32_t tile = 0;    // that owns it
  std::array<double, 3> point{};
  // The volume of its Voronoi cell, in 2D the area, in units of the coordinates: infinite for a vertex of the hull.
  double voronoi_volume = 0;
  std::vector<std::uint64_t> neighbors;   // ranks, ascending
  std::vector<std::uint64_t> cells;       // m x (d+1) ranks
  std::vector<std::uint32_t> cell_tiles;  // m: of each cell its main tile
};

// Of n points. What weighs on values[i] is vertices[k] with weights[k], offsets[i] <= k < offsets[i+1].
struct Interpolated {
  std::vector<double> values;           // n; NaN outside the hull
  std::vector<std::uint64_t> offsets;   // n+1; empty, as those below, when weights were not asked for
  std::vector<std::uint64_t> vertices;  // ranks
  std::vector<double> weights;          // they add up to 1 for each point inside the hull
};

enum class Method {
  linear,   // barycentric, in the cell that has the point
  natural,  // Sibson's natural neighbours; linear on facets of the hull
};

// Keeps tiles that were read in memory for the next question. Safe to call at once from several threads; copies share
// what is in memory. Failure of every call: usage for an argument that makes no sense, corrupt for a damaged tile, io,
// interrupted when `stop` is requested.
class TESSERA_PUBLIC Questions {
 public:
  // `memory_bytes`: for tiles; 0: 1 GiB. `threads`: of one question; 0: all processors. Failure: usage for a region.
  explicit Questions(const Triangulation& triangulation, std::uint64_t memory_bytes = 0, unsigned threads = 0);

  // `points`: n x d coordinates, row after row. Of several cells that have a point it is the one whose sorted ranks
  // come first, whatever the tiles. Failure: usage for coordinates that are not finite.
  Located locate(std::span<const double> points, std::stop_token stop = {}) const;
  // `tile`: the one that owns the vertex, if it is known; else tiles are read until it is found. Failure: usage for no
  // such vertex.
  Star star(std::uint64_t vertex, std::optional<std::uint32_t> tile = {}, std::stop_token stop = {}) const;
  // All cells that have a point in common with the closed box, d lower bounds, then d upper ones; as one Tile, whose
  // vertices are all its own, whose cells are all main, and whose neighbours are -1 where there is none among these
  // cells. Its id() says nothing. Failure: memory for more than `cells_max` cells.
  Tile cells_of_box(std::span<const double> box, std::uint64_t cells_max = std::numeric_limits<std::uint64_t>::max(),
                    std::stop_token stop = {}) const;
  // The same of the polygons of a GeoJSON text, in the coordinates of the result; by the even-odd rule. Failure:
  // bad_input when it has none.
  Tile cells_of_polygons(const std::string& geojson,
                         std::uint64_t cells_max = std::numeric_limits<std::uint64_t>::max(),
                         std::stop_token stop = {}) const;
  // `value`: an attribute of the vertices; "z" of a 2D result are the heights. Failure: usage when there is none.
  Interpolated interpolate(std::span<const double> points, const std::string& value, Method method = Method::linear,
                           bool weights = false, std::stop_token stop = {}) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace tessera

// Questions to a finished result: which cell contains a point, what is around a vertex, which cells meet a box or
// polygons, and what the values between vertices are. Answers are exact, and a question reads only the tiles that its
// answer needs (docs/queries.md).
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

// In this file a source index is the rank of a point in the input, counted from 0 (Tile::ids()), and d is the dimension
// of the result. Programs are compiled with the sizes of the structs below, so the structs never change.

// The cells that contain n points. All numbers are -1 for a point outside the hull.
struct Located {
  std::vector<std::int64_t> tiles;     // n: the main tile of the cell, as Tile::id()
  std::vector<std::int64_t> cells;     // n: the index of the cell in cells() of that tile
  std::vector<std::int64_t> vertices;  // n x (d+1): the source indices of the cell's vertices, positively oriented
};

// A vertex with the m cells around it.
struct Star {
  std::uint64_t vertex = 0;  // source index; for a duplicate that of the kept point
  std::uint32_t tile = 0;    // the owner of the vertex
  std::array<double, 3> point{};
  // The volume of the vertex's Voronoi cell, in 2D the area, in units of the coordinates; infinite on the hull.
  double voronoi_volume = 0;
  std::vector<std::uint64_t> neighbors;   // source indices, ascending
  std::vector<std::uint64_t> cells;       // m x (d+1): source indices of the vertices of each cell
  std::vector<std::uint32_t> cell_tiles;  // m: the main tile of each cell
};

// Values at n points. values[i] is the sum of the values of vertices[k], times weights[k], over all k with
// offsets[i] <= k < offsets[i+1].
struct Interpolated {
  std::vector<double> values;           // n; NaN outside the hull
  std::vector<std::uint64_t> offsets;   // n+1; this array and those below are empty if no weights were asked for
  std::vector<std::uint64_t> vertices;  // source indices
  std::vector<double> weights;          // the weights of a point inside the hull add up to 1
};

enum class Method {
  linear,   // barycentric, in the cell that contains the point
  natural,  // Sibson's natural neighbours; linear on facets of the hull
};

// Answers questions, and keeps the tiles that it has read in memory for the next question. All functions may be called
// from several threads at once. Copies share the tiles in memory. Failure of every function: usage for an argument that
// makes no sense, corrupt for a damaged tile, io, interrupted when `stop` is requested.
class TESSERA_PUBLIC Questions {
 public:
  // `memory_bytes` is for the tiles in memory; 0: 1 GiB. `threads` is for each question; 0: all processors. Failure:
  // also usage for a result that is a region.
  explicit Questions(const Triangulation& triangulation, std::uint64_t memory_bytes = 0, unsigned threads = 0);

  // Returns the cell that contains each point. `points`: n x d coordinates, row after row. If several cells contain a
  // point, the answer is the cell whose sorted source indices come first, so the answer does not depend on the tiles.
  // Failure: also usage for coordinates that are not finite.
  Located locate(std::span<const double> points, std::stop_token stop = {}) const;
  // Returns the cells around a vertex. `tile`: the owner of the vertex; if it is not given, tiles are read until the
  // vertex is found. Failure: also usage for a source index that no point has.
  Star star(std::uint64_t vertex, std::optional<std::uint32_t> tile = {}, std::stop_token stop = {}) const;
  // Returns the source indices of the vertices that share an edge with a vertex, ascending. Arguments and failure: as
  // star().
  std::vector<std::uint64_t> neighbours(std::uint64_t vertex, std::optional<std::uint32_t> tile = {},
                                        std::stop_token stop = {}) const;
  // Returns all cells that have a point in common with the closed box: d lower bounds, then d upper bounds. In the Tile
  // that is returned no vertex is foreign and no cell is a ghost. Its neighbours are -1 where the neighbour is not one
  // of these cells, and its id() has no meaning. Failure: also memory for more than `cells_max` cells.
  Tile cells_of_box(std::span<const double> box, std::uint64_t cells_max = std::numeric_limits<std::uint64_t>::max(),
                    std::stop_token stop = {}) const;
  // Returns the same for the polygons of a GeoJSON text, in the coordinates of the result, by the even-odd rule; in 3D
  // the polygons are prisms without ends. Failure: also bad_input for a text without polygons.
  Tile cells_of_polygons(const std::string& geojson,
                         std::uint64_t cells_max = std::numeric_limits<std::uint64_t>::max(),
                         std::stop_token stop = {}) const;
  // Returns the value at each point. `points`: n x d coordinates, row after row. `value`: an attribute of the vertices;
  // "z" in a 2D result is the height. `weights`: also return the vertices and weights. Failure: also usage for an
  // attribute that the result does not have.
  Interpolated interpolate(std::span<const double> points, const std::string& value, Method method = Method::linear,
                           bool weights = false, std::stop_token stop = {}) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace tessera

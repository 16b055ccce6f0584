// What tiles send each other on the way to a surface. A receiver always holds the cell, because it owns a vertex of it.
#pragma once

#include <cstdint>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/surface/surface_tile.h"

namespace tessera::surface {

// A ray that leaves `cell` across the facet opposite `opposite`.
struct RayRecord {
  Point from, towards;
  double sigma = 0;
  double reached = 0;  // the distance of the last facet from `from`
  CellName cell;
  PointId opposite;
  std::uint32_t vote = 0;
  std::uint32_t behind = 0;  // 1: the ray goes away from the sensor
  std::uint64_t steps = 0;   // cells that it has passed so far
  PointId of;                // the vertex at which it begins
};

// Excess, for the cell's main tile.
struct VoteRecord {
  CellName cell;
  std::int64_t votes = 0;
};

// What rays have given to the arc out of the cell, for the facet's main tile.
struct SumRecord {
  CellName cell;
  PointId opposite;
  std::uint32_t weight = 0, unused = 0;
};

// From the facet's main tile, which has received all sums, to the cell's main tile.
struct ArcRecord {
  CellName cell;
  PointId opposite, across;  // the vertices of the cell and of the cell across the facet that are not in the facet
  TileId across_tile;        // the main tile of the cell across
  std::uint32_t out = 0, in = 0, unused = 0;
};

// From a cell's main tile to the other tiles that hold the cell.
struct LabelRecord {
  CellName cell;
  std::uint64_t outside = 0;
};

}  // namespace tessera::surface

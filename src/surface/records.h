// What tiles tell each other on the way to a surface. Whoever is told holds the cell, as it owns a vertex of it.
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
  double reached = 0;  // how far from `from` the last facet was
  CellName cell;
  PointId opposite;
  std::uint32_t vote = 0;
  std::uint32_t behind = 0;  // 1: it goes away from the sensor
  std::uint64_t steps = 0;   // through cells, so far
  PointId of;                // the vertex that it goes from
};

// To the cell's main tile: excess.
struct VoteRecord {
  CellName cell;
  std::int64_t votes = 0;
};

// To the facet's main tile: what rays have given the arc out of the cell.
struct SumRecord {
  CellName cell;
  PointId opposite;
  std::uint32_t weight = 0, unused = 0;
};

// From the facet's main tile, which has heard of all sums, to the cell's main tile.
struct ArcRecord {
  CellName cell;
  PointId opposite, across;  // the corner of the cell, and of the one across the facet, that are not of the facet
  TileId across_tile;        // in which the cell across is main
  std::uint32_t out = 0, in = 0, unused = 0;
};

// From a cell's main tile to the others that hold it.
struct LabelRecord {
  CellName cell;
  std::uint64_t outside = 0;
};

}  // namespace tessera::surface

// A tile kept as its points. The tile's cells are those cells of the Delaunay triangulation of all these points that
// have an own vertex, so they can be rebuilt.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"

namespace tessera {

// A tile of n points: the tile's own points in the order of the mesh, then foreign points.
struct PointsTile {
  int dimension = 3;
  TileId tile;
  std::uint64_t own = 0;
  std::vector<Point> points;
  std::vector<PointId> ids;
  std::vector<TileId> owners;  // `tile` for the own points
  std::vector<Attribute> schema;
  std::vector<std::byte> rows;  // n rows of the schema; empty when they were not asked for
  std::uint64_t cells = 0;      // that follow from the points
  std::vector<Attribute> cell_schema;
  std::vector<std::vector<std::byte>> cell_columns;  // by column, then by cell in canonical order; may be empty
};

// A view of a tile that other code owns. REQUIRES: what holds for a PointsTile with rows; the schema is a
// stored_schema(); coordinates are finite and not -0, and z is 0 in 2D; the owner of no foreign point is the tile.
// Owners of the own points are not read.
struct PointsTileView {
  int dimension = 3;
  TileId tile;
  std::uint64_t own = 0;
  std::span<const Point> points;
  std::span<const PointId> ids;
  std::span<const TileId> owners;
  const std::vector<Attribute>& schema;
  std::span<const std::byte> rows;
  std::uint64_t cells = 0;  // their number is all that is known of the cells
};

inline PointsTileView view_of(const PointsTile& tile) {
  return {tile.dimension, tile.tile, tile.own, tile.points, tile.ids, tile.owners, tile.schema, tile.rows, tile.cells};
}

}  // namespace tessera

// A tile kept as its points: its cells are those of the Delaunay triangulation of all of them that have a vertex of its
// own, and can be made again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"

namespace tessera {

// n points: the tile's own ones in the order of the mesh, then foreign ones.
struct PointsTile {
  int dimension = 3;
  TileId tile;
  std::uint64_t own = 0;
  std::vector<Point> points;
  std::vector<PointId> ids;
  std::vector<TileId> owners;  // of the own ones, `tile`
  std::vector<Attribute> schema;
  std::vector<std::byte> rows;  // n of the schema; or none, when they were not asked for
  std::uint64_t cells = 0;      // that follow from the points
  std::vector<Attribute> cell_schema;
  std::vector<std::vector<std::byte>> cell_columns;  // in its order, by cell in canonical order; or none, likewise
};

// The same, of whoever has it. REQUIRES: as of a PointsTile with rows; the schema is a stored_schema(); coordinates are
// finite and not -0, and in 2D z is 0; owners of the own points, which nobody looks at, are the tile, and of no others.
struct PointsTileView {
  int dimension = 3;
  TileId tile;
  std::uint64_t own = 0;
  std::span<const Point> points;
  std::span<const PointId> ids;
  std::span<const TileId> owners;
  const std::vector<Attribute>& schema;
  std::span<const std::byte> rows;
  std::uint64_t cells = 0;  // of which nothing is said but how many they are
};

inline PointsTileView view_of(const PointsTile& tile) {
  return {tile.dimension, tile.tile, tile.own, tile.points, tile.ids, tile.owners, tile.schema, tile.rows, tile.cells};
}

}  // namespace tessera

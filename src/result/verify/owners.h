// Whether every vertex, foreign ones too, is said to be the tile's that the partition gives it to.
#pragma once

#include <optional>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"

namespace tessera {

// Queries go from a tile to a neighbour by the owners of foreign vertices, and nothing else in a result depends on
// them. Which tile has a vertex as its own follows from the coordinates, so an owner needs no other tile's file.
class Owners {
 public:
  // Format 1 and partitions that cannot be read tell nothing: the latter are for check_boxes() to find.
  explicit Owners(const Manifest& manifest);
  // Remembers the first vertex that has another owner.
  void look_at(const TileMesh& mesh, TileId tile, const TileSource& source);
  // Error not_delaunay names it.
  Status finish() const;

 private:
  std::optional<Partition> partition_;
  std::optional<Error> wrong_;
};

}  // namespace tessera

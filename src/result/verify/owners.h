// Checks the owner that each tile file gives for each vertex, foreign vertices included, against the partition.
#pragma once

#include <optional>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/tile_source.h"
#include "src/tiling/partition.h"

namespace tessera {

// Queries go from a tile to its neighbours by the owners of foreign vertices. Nothing else in a result depends on these
// owners. The coordinates of a vertex tell which tile owns it, so the check needs no other tile's file.
class Owners {
 public:
  // Nothing is checked for format 1, nor when the partition cannot be read: check_boxes() reports such a partition.
  explicit Owners(const Manifest& manifest);
  // Remembers the first vertex with a wrong owner.
  void look_at(const TileMesh& mesh, TileId tile, const TileSource& source);
  // Error not_delaunay names that vertex.
  Status finish() const;

 private:
  std::optional<Partition> partition_;
  Period period_;
  std::optional<Error> wrong_;
};

}  // namespace tessera

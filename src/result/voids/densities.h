// The densities of the vertices of a result, from its columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/base/result.h"
#include "src/result/measure/star_density.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera::voids {

// By vertex of a tile, in the order of the file.
struct TileDensities {
  std::vector<double> levels;  // Level::value; NaN for a vertex that belongs to no zone
  // Of own vertices, else 0: the volume (in 2D the area) of the Voronoi cell, 0 outside of all zones, and how many
  // points the vertex stands for, its duplicates included.
  std::vector<double> volumes, points;
};

// A vertex on the hull has an unbounded Voronoi cell. Its density would be 0, the deepest of all, so it belongs to no
// zone, and nothing flows through it.
class Densities {
 public:
  // `by` is "voronoi", or the name of a column of vertices that has densities. Errors: usage when the result lacks a
  // column; those of VertexMasses::open().
  static Result<Densities> open(const TileSource& source, const std::string& by, std::uint64_t memory_bytes);
  // The column that open() needs in any case, and whether a result has a column of vertices.
  static std::string volume_column(int dimension);
  static bool has_column(const Manifest& manifest, const std::string& name);

  // REQUIRES: the tile was read with rows. Errors: bad_input for a density that is negative or NaN; corrupt for a
  // volume that is.
  Result<TileDensities> of(const TileSource& source, std::size_t index, const StoredTile& tile) const;
  // The density of a level: points per unit of volume, or the unit of the column.
  double density(double level) const { return by_volume_ ? -1 / level : level; }
  // The density of the level `of`, divided by that of `core`, which is not higher; 1 for equal levels, also of density
  // 0.
  double contrast(double core, double of) const { return core == of ? 1 : by_volume_ ? core / of : of / core; }

 private:
  std::string name_;
  bool by_volume_ = true;
  AttributeColumn volume_, density_;
  std::size_t row_bytes_ = 0;
  VertexMasses points_;
};

}  // namespace tessera::voids

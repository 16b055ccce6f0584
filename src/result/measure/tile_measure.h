// One kind of measure: its columns, and their values for each tile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/measure/exact_volume.h"
#include "src/result/pass.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera {

class VertexMasses;  // star_density.h

// What a measure computes of the cells of one tile, from the exact volumes of the cells.
class CellValues {
 public:
  virtual ~CellValues() = default;
  // Called once for each cell, with its d + 1 vertices in the order of the file, and d! times its volume.
  virtual void take(std::size_t cell, std::span<const std::int32_t> vertices, const ScaledInteger& exact) = 0;
  // The values in the order of the columns, when all cells were taken.
  virtual PassValues finish() = 0;
};

class TileMeasure {
 public:
  virtual ~TileMeasure() = default;
  // Name, type, unit, and whether the column is of cells.
  virtual std::vector<ResultColumn> columns() const = 0;
  // A measure of cells, which needs their volumes, overrides cells_of(); another one overrides of(). Both are called by
  // several threads, once for each tile. Measures of cells share the volumes, because these take the most time.
  virtual std::unique_ptr<CellValues> cells_of(const TileMesh& /*mesh*/) { return nullptr; }
  // The values of a tile, in the order of the columns. Errors: corrupt for a cell that is not positively oriented;
  // interrupted.
  virtual Result<PassValues> of(std::size_t /*index*/, const StoredTile& /*tile*/) { return PassValues{}; }
  // Called after all tiles. Sets what is known of a column as a whole; `columns` are those of columns().
  virtual void finish(std::vector<ResultColumn>& columns) const = 0;
  // How many values were too large for a double. Each cell and vertex counts once.
  virtual std::uint64_t infinite() const = 0;
  // A remark about the values; else empty.
  virtual std::string note() const { return ""; }
};

// The volume of each cell, and for each vertex the sum over the cells around it; in 2D areas in the plane.
std::unique_ptr<TileMeasure> measure_volumes(const TileSource& source);
// The shape of each cell (cell_quality.h).
std::unique_ptr<TileMeasure> measure_quality(const TileSource& source);
// The Voronoi cell of each vertex: its volume, surface, number of neighbours and centroid (voronoi_part.h). REQUIRES:
// the result is a whole triangulation.
std::unique_ptr<TileMeasure> measure_voronoi(const TileSource& source, std::stop_token stop);

// The density of each vertex (star_density.h). `mass` is the attribute that has the masses, or empty: each point has
// the mass 1. Errors: those of VertexMasses::open(). REQUIRES: the result is a whole triangulation.
Result<std::unique_ptr<TileMeasure>> measure_density(const TileSource& source, const std::string& mass,
                                                     std::uint64_t memory_bytes, std::stop_token stop);
// The same with masses that are known.
std::unique_ptr<TileMeasure> measure_density(const TileSource& source, VertexMasses masses, const std::string& mass,
                                             std::stop_token stop);

// Values of all measures, one after the other.
Result<PassValues> values_of(const std::vector<std::unique_ptr<TileMeasure>>& measures, const TileSource& source,
                             std::size_t index, const StoredTile& tile, const std::stop_token& stop);

// The unit of lengths to the power of `exponent`; "" when it is not known or not the same on all axes.
std::string unit_of(const Manifest& manifest, int exponent);

}  // namespace tessera

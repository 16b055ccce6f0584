// The densities of vertices by the Delaunay tessellation field estimator (DTFE): (d + 1) times the mass of the vertex,
// divided by the volume of its star, which is the sum of the volumes of the cells around the vertex. The function that
// is linear in each cell and has these values at the vertices has the sum of the masses as its integral. At the hull
// the star is that of the cells within the hull.
// Source: Schaap, van de Weygaert, Continuous fields and discrete samples: reconstruction through Delaunay
// tessellations, Astronomy & Astrophysics 363 (2000).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/result/measure/scaled_double.h"
#include "src/result/store/tile_store.h"
#include "src/result/tile_source.h"

namespace tessera {

// The masses of the vertices of a result.
//
// Without an attribute each point has the mass 1, so a vertex has the mass 1 + the number of its duplicates. With an
// attribute a vertex has the value of the attribute. The values of duplicates are not in a result, so they do not
// count.
class VertexMasses {
 public:
  // Reads which vertices have duplicates. `attribute` is the name of an attribute of the vertices, or empty. Errors:
  // usage when the vertices have no such attribute; memory when the list of duplicates does not fit into
  // `memory_bytes`; corrupt, io.
  static Result<VertexMasses> open(const TileSource& source, const std::string& attribute, std::uint64_t memory_bytes);
  // The masses of points that have the mass 1 each, in a result with these duplicates.
  static VertexMasses counted(std::span<const DuplicatePair> duplicates);

  // The masses of the vertices of a tile, in the order of the file; those of foreign vertices are 0. `source` has the
  // attributes of the one that was opened. Errors: mass_not_finite(); those of reading.
  Result<std::vector<double>> of(const TileSource& source, std::size_t index, const TileMesh& mesh) const;

  // A sentence about duplicates whose masses do not count; else empty.
  std::string note() const;

 private:
  // A vertex with duplicates.
  struct Shared {
    PointId vertex;
    std::uint64_t duplicates = 0;
  };
  std::string result_;  // for errors
  std::string attribute_;
  std::optional<AttributeColumn> column_;
  std::size_t row_bytes_ = 0;
  std::vector<Shared> shared_;  // by vertex
  std::uint64_t left_out_ = 0;  // duplicates whose masses are not known
};

// Error bad_input: the attribute or column `name` of a vertex is no mass.
Error mass_not_finite(const std::string& result, const std::string& name, PointId vertex, double mass);

// The densities of the tile's own vertices; 0 for foreign ones. Errors: corrupt for a cell that is not positively
// oriented; interrupted.
Result<std::vector<ScaledDouble>> star_densities(const TileSource& source, std::size_t index, const TileMesh& mesh,
                                                 std::span<const double> masses, const std::stop_token& stop);

}  // namespace tessera

// The part of an alpha shape that one tile decides: the faces of which the tile is the main one.
//
// The main tile of a face is the tile with the lowest id among the owners of its vertices. This tile has all cells
// around the face, because a tile has every cell with a vertex of its own. So no tile needs to ask another one. Of the
// copies of a face in a periodic result one is the main one. The vertices of faces are images there, in the copy of the
// face that does not depend on tiles (base_offset()).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/image.h"
#include "src/base/result.h"
#include "src/geometry/mesh/tile_mesh.h"
#include "src/result/alpha/shape_simplex.h"

namespace tessera::alpha {

// The vertices of the facet opposite corner k, in the order in which they are seen counterclockwise from outside the
// cell; in 2D with the cell on their left. The first d of them are used.
std::array<std::int32_t, 3> facet_of(const TileMesh& mesh, std::size_t cell, std::size_t k);

class TileAlpha {
 public:
  // Gets the simplices a few thousand at a time.
  using Take = std::function<Status(std::span<const ShapeSimplex>)>;

  // Compares all cells of the tile `self` with the radius. The mesh must outlive this object. Throws Stopped.
  TileAlpha(const TileMesh& mesh, TileId self, const Period& period, double radius, std::stop_token stop);

  // By cell: 1 when the cell is in the shape.
  const std::vector<std::uint8_t>& in() const { return in_; }
  std::uint64_t main_cells() const;
  // Finds the facets on the boundary. Errors: those of `take`. Throws Stopped.
  Status regular_facets(const Take& take) const;
  // Finds the singular faces. Needs some 80 bytes more for a cell. Errors: those of `take`. Throws Stopped.
  Status singular_faces(const Take& take) const;

 private:
  struct Faces;
  class Batch;
  void look_for_stop(std::size_t cell) const;
  bool in_complex(std::span<const std::int32_t> face, std::span<const std::int32_t> opposite) const;
  Status find_facets(Faces& faces, Batch& batch) const;
  Status find_edges(Faces& faces, Batch& batch) const;

  const TileMesh& mesh_;
  TileId self_;
  Period period_;
  double radius_;
  std::stop_token stop_;
  std::size_t corners_;
  std::vector<std::uint8_t> in_;
};

}  // namespace tessera::alpha

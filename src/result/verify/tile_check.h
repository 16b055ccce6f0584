// Checks what can be checked inside one tile file, and makes the records that are compared between tiles.
//
// The proof. Let M be the set of main cells. By check_cell_copies(), the tile that owns a vertex has every cell of M
// around the vertex exactly once, with the same coordinates. A facet is judged by the tile that owns the facet's vertex
// of the least id, so that tile has all cells of M with the facet. There each cell is glued to the cell that its
// neighbour array names: that cell must have the same facet, name the first cell in turn, and lie on the other side. If
// the array names none, the facet is a hull facet. So the facets of M are glued in pairs, except hull facets. All cells
// are positively oriented, so they cover each point as often as the hull winds around it, which is once (hull.h). So M
// is a triangulation of the convex hull, in which exactly two cells share each inner facet. Each pair is locally
// Delaunay with the tie rule. So by the Delaunay lemma M is the perturbed Delaunay triangulation.
//
// In a periodic result all of this holds for images of tiles, vertices, facets and cells. A vertex is the own one of a
// tile only where its offset is 0. A tile has one copy of a cell for each of its points in the cell that has an offset
// of its own, and a facet is judged where the facet's least vertex is an own one. periodic_space.h replaces hull.h.
#pragma once

#include <cstdint>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/tile_source.h"
#include "src/result/verify/cell_copies.h"
#include "src/result/verify/hull.h"
#include "src/result/verify/periodic_space.h"
#include "src/result/verify/vertex_ids.h"

namespace tessera {

// What a tile says of a facet that another tile judges.
enum class Claim : std::uint8_t { on_hull, said_outside, said_elsewhere };

struct FacetClaim {
  IdSet ids;
  TileId tile;
  std::uint32_t cell;
  Claim claim;            // on_hull: not said, but found by the tile that judges the facet
  std::uint8_t copy = 0;  // the offset by which `ids` were shifted, as a code: which copy of the facet it is
  friend bool operator<(const FacetClaim& a, const FacetClaim& b) {
    return a.ids != b.ids       ? a.ids < b.ids
           : a.claim != b.claim ? a.claim < b.claim
           : a.tile != b.tile   ? a.tile < b.tile
                                : a.copy < b.copy;
  }
};

struct TileSinks {
  ExternalSort<CellCopy>& copies;
  ExternalSort<OwnVertex>& own;
  ExternalSort<FacetClaim>& claims;
  Hull& hull;
  PeriodicSpace* space;      // null: the result has no period
  std::uint64_t facets = 0;  // judged so far
};

// Checks a tile and passes its records to `sinks`. `neighbors_stored` is true when mesh.neighbors come from the file,
// so that -1 and -2 are claims to be checked.
Status check_tile(const TileMesh& mesh, TileId tile, bool neighbors_stored, const TileSource& source, TileSinks& sinks,
                  std::stop_token stop);

// Checks the claims of all tiles.
Status check_claims(ExternalSort<FacetClaim>& claims, const TileSource& source);

}  // namespace tessera

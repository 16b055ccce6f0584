// What can be seen inside one tile file, and the records that leave it to be compared with other tiles.
//
// The proof. Let M be the main cells. By check_cell_copies(), the tile that owns a vertex holds every cell of M around
// it exactly once, with the same coordinates. A facet is judged by the tile that owns its vertex of the least id, which
// therefore holds all cells of M that have it. There each is glued to the one its neighbour array names: that must have
// the same facet, name it in turn, and lie on the other side; or there is none, and it is a hull facet. So the facets
// of M are glued in pairs, but for hull facets. All cells are positively oriented, so they cover each point as often as
// the hull winds around it, which is once (hull.h): M is a triangulation of the convex hull, its facets shared by
// exactly two cells. Each pair is locally Delaunay with the tie rule, so by the Delaunay lemma M is the perturbed
// Delaunay triangulation.
#pragma once

#include <cstdint>
#include <stop_token>

#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/tile_source.h"
#include "src/result/verify/cell_copies.h"
#include "src/result/verify/hull.h"
#include "src/result/verify/vertex_ids.h"

namespace tessera {

// What a tile says of a facet that another tile judges.
enum class Claim : std::uint8_t { on_hull, said_outside, said_elsewhere };

struct FacetClaim {
  IdSet ids;
  TileId tile;
  std::uint32_t cell;
  Claim claim;  // on_hull: not said, but found by the tile that judges the facet
  friend bool operator<(const FacetClaim& a, const FacetClaim& b) {
    return a.ids != b.ids ? a.ids < b.ids : a.claim != b.claim ? a.claim < b.claim : a.tile < b.tile;
  }
};

struct TileSinks {
  ExternalSort<CellCopy>& copies;
  ExternalSort<OwnVertex>& own;
  ExternalSort<FacetClaim>& claims;
  Hull& hull;
  std::uint64_t facets = 0;  // judged so far
};

// `neighbors_stored`: mesh.neighbors come from the file, so that -1 and -2 are claims to be checked.
Status check_tile(const TileMesh& mesh, TileId tile, bool neighbors_stored, const TileSource& source, TileSinks& sinks,
                  std::stop_token stop);

// Whether the claims of all tiles hold.
Status check_claims(ExternalSort<FacetClaim>& claims, const TileSource& source);

}  // namespace tessera

// Walks through the cells of a result, from tile to tile.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/tile_cache.h"

namespace tessera::query {

// A cell as one of the tiles that hold it has it; no tile: outside the hull.
struct Place {
  const QueryTile* tile = nullptr;
  std::int32_t cell = -1;
  explicit operator bool() const { return tile != nullptr; }
};

// The cell that is the answer to a point, and on which of its facets the point lies.
struct Located {
  Place place;
  unsigned on_facets = 0;  // bit k: it is on the facet opposite vertex k
  bool final = true;       // so it is in the whole triangulation, of which the result may be a part
};

// Of one thread. A Place is good as long as its tile is pinned.
class Walker {
 public:
  // `with_rows`: tiles with the attributes of their vertices.
  Walker(TileCache& cache, const Manifest& manifest, bool with_rows)
      : cache_(cache), steps_max_(manifest.cells + 1), with_rows_(with_rows) {}

  // A tile, pinned from here on. Errors: those of TileCache::get().
  Result<const QueryTile*> tile(TileId id);
  // Gives back all others. Null: all.
  void keep_only(const QueryTile* tile);

  // The neighbour across the facet opposite corner k; none: the facet is on the hull. What the tile does not know, the
  // owner of a vertex of the facet does: it holds all cells around its vertices. Error corrupt when it does not.
  // In a part of a triangulation there is also none where no cell is known.
  Result<Place> across(Place from, std::size_t k);
  // Of a part: since forget_doubts(), whether across() met a facet beyond which no cell is known, and one that is not
  // for sure of the whole.
  bool met_unknown() const { return met_unknown_; }
  bool met_unsure() const { return met_unsure_; }
  void forget_doubts() { met_unknown_ = met_unsure_ = false; }
  // The same cell in another tile, which owns one of its vertices. Error corrupt when it is not there.
  Result<Place> same_in(Place place, TileId id);
  // The same cell in its main tile.
  Result<Place> main_place(Place place) { return same_in(place, place.tile->main_tile(place.cell)); }

  // The cell whose closed set has q; of several the one whose sorted source indices come first, so that the answer is a
  // function of the triangulation and q alone. No place: q is outside the hull. Exact. From `from` on, which becomes
  // the last cell visited; all tiles are given back but that of `from` and of the answer. q is finite, in 2D with z =
  // 0.
  //
  // A visibility walk: across any facet that has q strictly on its other side, until there is none. It ends: a Delaunay
  // triangulation, cospherical ties broken as if points were lifted, is regular, and in such no point sees cells in a
  // cycle (Edelsbrunner, An acyclicity theorem for cell complexes in d dimensions, Combinatorica 1990). It goes on in
  // another tile with the very cell that it has come to, so it is one walk whatever the tiles. Beyond a facet of the
  // hull, which is convex, there is nothing. Damaged files cannot make it walk for ever: it counts its steps.
  Result<Located> locate(const Point& q, Place& from);

 private:
  template <int d>
  Result<Located> walk(const Point& q, Place& at);
  // Of the cells around a face of `found` that has q in its inside, the first.
  Result<Located> choose(const Point& q, const Located& found);

  TileCache& cache_;
  std::uint64_t steps_max_;
  bool with_rows_;
  std::vector<PinnedTile> pinned_;
  bool met_unknown_ = false, met_unsure_ = false;
};

// Bit k: q is on the plane of the facet opposite corner k. Exact.
unsigned facets_through(const Place& place, const Point& q);

}  // namespace tessera::query

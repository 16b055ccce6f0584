// Walks through the cells of a result, from tile to tile.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/tile_cache.h"
#include "src/result/store/period.h"

namespace tessera::query {

// A cell in one of the tiles that have it; no tile: outside the hull. In a periodic result the cell that is meant lies
// `shift` periods away from where the tile has it.
struct CellRef {
  const QueryTile* tile = nullptr;
  std::int32_t cell = -1;
  PeriodOffset shift = {};
  explicit operator bool() const { return tile != nullptr; }
  // Where corner k of the cell lies.
  Point corner(std::size_t k) const { return tile->period().shifted(tile->point(tile->vertex(cell, k)), shift); }
};

// The cell that contains a point, and the facets on which the point lies.
struct Located {
  CellRef place;
  unsigned on_facets = 0;  // bit k: the point is on the facet opposite vertex k
  bool final = true;       // holds in the whole triangulation, too, when the result is a region
};

// Used by one thread. A CellRef is valid as long as its tile is pinned.
class Walker {
 public:
  // `with_rows`: read tiles with the attributes of their vertices.
  Walker(TileCache& cache, const Manifest& manifest, bool with_rows)
      : cache_(cache),
        steps_max_((manifest.cells + 1) * (is_periodic(manifest) ? image::codes : 1)),
        with_rows_(with_rows) {}

  // Returns a tile, which the walker pins. Errors: those of TileCache::get().
  Result<const QueryTile*> tile(TileId id);
  // Unpins all tiles but this one. Null: all tiles.
  void keep_only(const QueryTile* tile);

  // The neighbour across the facet opposite corner k; no place when the facet is on the hull. When the tile does not
  // know the neighbour, the owner of a vertex of the facet does, because it has all cells around its vertices. Error
  // corrupt when that tile does not know it. In a region, there is also no place when the cell is unknown.
  Result<CellRef> across(CellRef from, std::size_t k);
  // For regions: whether across() has met, since forget_doubts(), a facet with an unknown cell beyond, and a cell that
  // is not surely one of the whole triangulation.
  bool met_unknown() const { return met_unknown_; }
  bool met_unsure() const { return met_unsure_; }
  void forget_doubts() { met_unknown_ = met_unsure_ = false; }
  // The same cell in another tile that owns one of its vertices. Error corrupt when that tile does not have it. In a
  // periodic result, of the tile's copies the one in which the least offset of the tile's own points is 0.
  Result<CellRef> same_in(CellRef place, TileId id);
  // The same cell in its main tile.
  Result<CellRef> main_place(CellRef place) { return same_in(place, place.tile->main_tile(place.cell)); }

  // Finds the cell that contains q, boundaries included. When several do, the one whose sorted source indices come
  // first, so the answer depends only on the triangulation and q. No place: q is outside the hull. Exact. The walk
  // begins at `from`, which becomes the last cell visited. Unpins all tiles except those of `from` and of the answer.
  // REQUIRES: q is finite; z = 0 in 2D.
  //
  // This is a visibility walk: it crosses any facet that has q strictly on its other side, until there is none. The
  // walk ends: a Delaunay triangulation, whose ties are broken as if points were lifted, is regular, and in a regular
  // triangulation no point sees cells in a cycle (Edelsbrunner, An acyclicity theorem for cell complexes in d
  // dimensions, Combinatorica 1990). The walk continues in another tile with the same cell, so it does not depend on
  // tiles. Beyond a facet of the hull there is nothing, because the hull is convex. The walk counts its steps, so
  // damaged files cannot make it endless.
  Result<Located> locate(const Point& q, CellRef& from);

 private:
  template <int d>
  Result<Located> walk(const Point& q, CellRef& at);
  // The same cell in the tile that owns a vertex, in the copy in which that vertex is the point itself.
  Result<CellRef> same_at(CellRef place, std::int32_t vertex);
  // The same cell in a tile, after a shift back by `base`.
  Result<CellRef> copy_in(CellRef place, TileId id, const PeriodOffset& base);
  // Returns the first of the cells around the face of `found` that has q in its interior.
  Result<Located> choose(const Point& q, const Located& found);

  TileCache& cache_;
  std::uint64_t steps_max_;
  bool with_rows_;
  std::vector<PinnedTile> pinned_;
  bool met_unknown_ = false, met_unsure_ = false;
};

// Bit k: q is on the plane of the facet opposite corner k. Exact.
unsigned facets_through(const CellRef& place, const Point& q);

}  // namespace tessera::query

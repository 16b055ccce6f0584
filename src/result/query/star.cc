#include "src/result/query/star.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "src/geometry/mesh/image_order.h"
#include "src/result/query/dual.h"
#include "src/result/query/opened_result.h"

namespace tessera::query {
namespace {

// The volume in the tile that owns the vertex, which has all of its cells: for each facet with the vertex, adds the
// Voronoi edge across it, seen from both sides. Infinite when a facet is on the hull; NaN when a cell has no volume, as
// only damaged results have.
double voronoi_volume(const QueryTile& tile, std::int32_t vertex, const std::vector<std::int32_t>& star) {
  const std::size_t corners = tile.corners();
  std::map<std::int32_t, std::vector<Vec<Wide>>> corners_of;
  std::map<std::int32_t, Vec<Wide>> centre_of;
  for (const std::int32_t cell : star) {
    auto& at = corners_of[cell];
    for (std::size_t k = 0; k < corners; ++k)
      at.push_back(relative<Wide>(tile.point(tile.vertex(cell, k)), tile.point(vertex)));
    const auto centre = circumcentre<Wide>(at);
    if (!centre) return std::numeric_limits<double>::quiet_NaN();
    centre_of[cell] = *centre;
  }
  Wide volume = 0;
  for (const std::int32_t cell : star) {
    for (std::size_t k = 0; k < corners; ++k) {
      if (tile.vertex(cell, k) == vertex) continue;
      const std::int32_t beyond = tile.neighbor(cell, k);
      if (beyond < 0) return std::numeric_limits<double>::infinity();
      std::array<Vec<Wide>, 3> facet;
      std::size_t here = 0;
      for (std::size_t i = 0; i + 1 < corners; ++i) {
        const std::size_t corner = facet_corner(corners, k, i);
        facet[i] = corners_of[cell][corner];
        if (tile.vertex(cell, corner) == vertex) here = i;
      }
      volume += edge_shares<Wide>({facet.data(), corners - 1}, centre_of[cell], centre_of[beyond])[here] / 2;
    }
  }
  return std::abs(static_cast<double>(rounded(volume)));
}

// The cells around a vertex in a region, where they may not be connected. Sets `final` if all are cells of the whole
// triangulation.
std::vector<std::int32_t> around_in_part(const QueryTile& tile, const CellTree& tree, std::int32_t vertex,
                                         bool& final) {
  std::vector<std::int32_t> star;
  tree.for_each_near({tile.point(vertex), tile.point(vertex)}, [&](std::int32_t cell) {
    for (std::size_t k = 0; k < tile.corners(); ++k)
      if (tile.vertex(cell, k) == vertex) star.push_back(cell);
  });
  final = std::all_of(star.begin(), star.end(), [&](std::int32_t cell) { return tile.is_final(cell); });
  return star;
}

// True if the neighbour across each facet with the vertex is known. Then there are no other cells around the vertex.
bool is_closed(const QueryTile& tile, std::int32_t vertex, const std::vector<std::int32_t>& star) {
  for (const std::int32_t cell : star)
    for (std::size_t k = 0; k < tile.corners(); ++k)
      if (tile.vertex(cell, k) != vertex && tile.neighbor(cell, k) < -1) return false;
  return true;
}

// The kept point of a duplicate; nothing if the point is no duplicate.
Result<std::optional<PointId>> kept_for(const TileSource& source, PointId id) {
  if (source.manifest().duplicates == 0) return std::optional<PointId>{};
  BOOST_OUTCOME_TRY(pairs, source.read_duplicates());
  const auto pair = std::lower_bound(pairs.begin(), pairs.end(), DuplicatePair{id, PointId{0}});
  if (pair == pairs.end() || pair->duplicate != id) return std::optional<PointId>{};
  return std::optional(pair->kept);
}

// The cells around a vertex, in the tile that owns it.
struct Around {
  const QueryTile* tile = nullptr;
  std::int32_t vertex = -1;
  std::vector<std::int32_t> cells;
  bool closed = true;  // no neighbour across a facet with the vertex is unknown
  bool final = true;   // these are exactly the cells around it in the whole triangulation
};

// Finds the tile that owns the vertex; for a duplicate, that of the kept point, and sets `id` to it.
Result<TileId> find_owner(const OpenedResult& result, PointId& id, const AskOptions& options) {
  const Manifest& manifest = result.manifest;
  BOOST_OUTCOME_TRY(found, result.owner_of(id, options.stop));
  if (found) return *found;
  BOOST_OUTCOME_TRY(kept, kept_for(result.source, id));
  if (manifest.region)
    return error(Errc::usage, result.out.string() + ": point " + to_string(id) +
                                  " of the input is a vertex of no cell of this region");
  if (!kept || *kept == id)
    return error(Errc::usage, result.out.string() + ": point " + to_string(id) +
                                  " of the input is no vertex: it was left out as invalid or filtered");
  id = *kept;
  return find_owner(result, id, options);
}

Result<Around> cells_around(const OpenedResult& result, PointId id, std::optional<TileId> owner,
                            const AskOptions& options, Walker& walker) {
  const Manifest& manifest = result.manifest;
  if (id.value >= manifest.points_read)
    return error(Errc::usage, result.out.string() + ": has no vertex " + to_string(id) + "; the input had " +
                                  std::to_string(manifest.points_read) + " points, counted from 0");
  const auto& tiles = manifest.tiles;
  if (owner && std::none_of(tiles.begin(), tiles.end(), [&](const TileEntry& entry) { return entry.tile == *owner; }))
    return error(Errc::usage, result.out.string() + ": has no tile " + to_string(*owner));
  if (!owner) {
    BOOST_OUTCOME_TRY(known, find_owner(result, id, options));
    owner = known;
  }
  Around found;
  BOOST_OUTCOME_TRY(tile, walker.tile(*owner));
  found.tile = tile;
  found.vertex = tile->own_vertex(id);
  if (found.vertex < 0)
    return error(Errc::usage, result.out.string() + ": tile " + to_string(*owner) + " has no vertex " + to_string(id));
  if (manifest.region) {
    BOOST_OUTCOME_TRY(tree, result.part_tree());
    found.cells = around_in_part(*tile, *tree, found.vertex, found.final);
  } else {
    BOOST_OUTCOME_TRY(cells, tile->around(found.vertex));
    found.cells = std::move(cells);
  }
  found.closed = is_closed(*tile, found.vertex, found.cells);
  found.final = found.final && found.closed;
  return found;
}

// The vertices that share an edge with the vertex, by id.
std::vector<std::int32_t> neighbours_in(const Around& of) {
  const QueryTile& tile = *of.tile;
  std::vector<std::int32_t> neighbours;
  for (const std::int32_t cell : of.cells)
    for (std::size_t k = 0; k < tile.corners(); ++k)
      if (tile.vertex(cell, k) != of.vertex) neighbours.push_back(tile.vertex(cell, k));
  std::sort(neighbours.begin(), neighbours.end(), [&](std::int32_t a, std::int32_t b) {
    return image_order(tile.mesh(), static_cast<std::size_t>(a)) <
           image_order(tile.mesh(), static_cast<std::size_t>(b));
  });
  neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
  return neighbours;
}

bool on_hull(const Around& of) {
  const QueryTile& tile = *of.tile;
  for (const std::int32_t cell : of.cells)
    for (std::size_t k = 0; k < tile.corners(); ++k)
      if (tile.vertex(cell, k) != of.vertex && tile.neighbor(cell, k) < 0) return true;
  return false;
}

}  // namespace

Result<Star> star_of(const OpenedResult& result, PointId id, std::optional<TileId> owner, const AskOptions& options) {
  Walker walker(result.cache, result.manifest, false);
  BOOST_OUTCOME_TRY(found, cells_around(result, id, owner, options, walker));
  const QueryTile& tile = *found.tile;
  Star star;
  star.vertex = vertex_at(tile, found.vertex);
  star.final = found.final;
  star.voronoi_volume =
      found.closed ? voronoi_volume(tile, found.vertex, found.cells) : std::numeric_limits<double>::quiet_NaN();
  for (const std::int32_t cell : found.cells) {
    BOOST_OUTCOME_TRY(main, walker.main_place({&tile, cell}));
    star.cells.push_back(cell_at(main));
    star.cells.back().final = tile.is_final(cell);
  }
  for (const std::int32_t v : neighbours_in(found)) star.neighbors.push_back(vertex_at(tile, v));
  std::sort(star.cells.begin(), star.cells.end(),
            [](const Cell& a, const Cell& b) { return a.tile != b.tile ? a.tile < b.tile : a.cell < b.cell; });
  return star;
}

Result<Neighbours> neighbours_of(const OpenedResult& result, PointId id, std::optional<TileId> owner,
                                 const AskOptions& options) {
  Walker walker(result.cache, result.manifest, false);
  BOOST_OUTCOME_TRY(found, cells_around(result, id, owner, options, walker));
  Neighbours told{.asked = id,
                  .vertex = found.tile->id_of(found.vertex),
                  .ids = {},
                  .on_hull = found.closed && on_hull(found),
                  .final = found.final};
  for (const std::int32_t v : neighbours_in(found)) {
    const PointId near = found.tile->id_of(v);
    if (near != told.vertex && (told.ids.empty() || told.ids.back() != near)) told.ids.push_back(near);
  }
  return told;
}

}  // namespace tessera::query

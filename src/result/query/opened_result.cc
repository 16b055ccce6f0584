#include "src/result/query/opened_result.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace tessera::query {

Cell cell_at(const CellRef& place) {
  Cell cell{.tile = place.tile->id(), .cell = place.cell};
  for (std::size_t k = 0; k < place.tile->corners(); ++k)
    cell.vertices[k] = place.tile->id_of(place.tile->vertex(place.cell, k));
  return cell;
}

Vertex vertex_at(const QueryTile& tile, std::int32_t vertex) {
  return {
      .id = tile.id_of(vertex), .owner = tile.owner(vertex), .at = tile.point(vertex), .offset = tile.offset(vertex)};
}

Result<const CellTree*> OpenedResult::part_tree() const {
  const std::lock_guard lock(tree_mutex);
  if (!tree) {
    BOOST_OUTCOME_TRY(tile, cache.get(manifest.tiles.front().tile, false));
    tree = std::make_unique<const CellTree>(*tile);
  }
  return tree.get();
}

// Moves by whole periods. A point between 0 and the period stays as it is.
std::vector<Point> OpenedResult::in_box(std::span<const Point> points) const {
  std::vector<Point> moved(points.begin(), points.end());
  const Period& period = source.period();
  for (int axis = 0; axis < 3; ++axis) {
    const double length = period.length[static_cast<std::size_t>(axis)];
    if (length == 0) continue;
    for (Point& p : moved) {
      double& x = p[axis];
      if (0 <= x && x < length) continue;
      x = std::fmod(x, length);
      if (x < 0) x += length;
      if (x >= length) x = 0;
    }
  }
  return moved;
}

Status OpenedResult::refuse_periods(const std::string& what) const {
  if (!source.period().any()) return success();
  return error(Errc::usage, out.string() + ": holds the triangulation of a periodic cloud, which does not answer " +
                                what +
                                "; it tells cells of points, stars, neighbours, and values that are linear in cells");
}

Status OpenedResult::locate(const Batch& batch, const VisitLocated& visit) const {
  if (!manifest.region) {
    Batch whole = batch;
    whole.period = source.period();
    return locate_all(cache, manifest, homes, whole, visit);
  }
  BOOST_OUTCOME_TRY(cells, part_tree());
  return locate_all_in_part(cache, manifest, *cells, batch, visit);
}

Result<Found> OpenedResult::find(Walker& walker, const Area& area, std::uint64_t cells_max,
                                 const std::stop_token& stop) const {
  if (!manifest.region) return search(walker, homes, manifest, area, cells_max, stop);
  BOOST_OUTCOME_TRY(cells, part_tree());
  return search_part(walker, manifest, *cells, area, cells_max, stop);
}

Result<std::optional<TileId>> OpenedResult::owner_of(PointId id, const std::stop_token& stop) const {
  for (std::size_t i = 0; i < manifest.tiles.size(); ++i) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while looking for a vertex");
    const TileId tile = manifest.tiles[i].tile;
    {
      const std::lock_guard lock(id_mutex);
      if (id_ranges[i] && (id < id_ranges[i]->first || id_ranges[i]->second < id)) continue;
    }
    BOOST_OUTCOME_TRY(ids, source.read_own_ids(i));
    const auto [least, most] = std::minmax_element(ids.begin(), ids.end());
    if (least == ids.end()) continue;
    {
      const std::lock_guard lock(id_mutex);
      id_ranges[i] = {*least, *most};
    }
    if (std::find(ids.begin(), ids.end(), id) != ids.end()) return std::optional(tile);
  }
  return std::optional<TileId>{};
}

}  // namespace tessera::query

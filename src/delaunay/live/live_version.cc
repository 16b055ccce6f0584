#include "src/delaunay/live/live_version.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "src/base/check.h"

namespace tessera {

LiveVersion::LiveVersion(std::uint64_t number, std::shared_ptr<const Partition> partition, Tiles tiles, IdTiles ids)
    : number_(number),
      partition_(std::move(partition)),
      tiles_(std::move(tiles)),
      ids_(std::move(ids)),
      corners_(partition_->dimension() + 1),
      memory_(ids_.memory()) {
  for (const auto& tile : tiles_) {
    if (!tile) continue;
    vertices_ += tile->triangulation().own_points();
    memory_ += tile->memory();
  }
}

const LiveTile& LiveVersion::tile_near(const Point& p) const {
  if (const auto& tile = tiles_[partition_->tile_of(p).value]) return *tile;
  const LiveTile* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    if (!tiles_[i]) continue;
    const Box& box = partition_->boxes()[i];
    double squared = 0;
    for (int axis = 0; axis + 1 < corners_; ++axis) {
      const double gap = std::max({box.lo[axis] - p[axis], p[axis] - box.hi[axis], 0.0});
      squared += gap * gap;
    }
    if (best && !(squared < least)) continue;
    best = tiles_[i].get();
    least = squared;
  }
  return *best;
}

std::array<PointId, 4> LiveVersion::ids_of(const LiveTile& tile, const CellRecord& cell) const {
  std::array<PointId, 4> out;
  out.fill(LiveCell::infinite);
  for (int i = 0; i < corners_; ++i) {
    if (cell.vertices[i] != infinite_vertex) out[i] = tile.triangulation().ids()[cell.vertices[i]];
  }
  return out;
}

LiveCell LiveVersion::cell(const Place& place) const {
  const CellRecord found = place.tile->row(place.row);
  LiveCell out;
  out.row = place.row;
  out.ids = ids_of(*place.tile, found);
  for (int i = 0; i < corners_; ++i) {
    if (found.vertices[i] == infinite_vertex) continue;
    const TileTriangulation& tile = place.tile->triangulation();
    out.points[i] = tile.kernel().point(found.vertices[i]);
    if (tile.is_own(found.vertices[i])) out.tile = tile.owner(found.vertices[i]);
  }
  return out;
}

// Finds the cell with these vertices in the tile of one of them, whose star is whole there.
LiveVersion::Place LiveVersion::in_other_tile(const LiveTile& tile, Vertex v, const std::array<PointId, 4>& ids) const {
  for (const LiveTile::Row r : tile.star(v)) {
    auto there = ids_of(tile, tile.row(r));
    std::sort(there.begin(), there.end());
    if (there == ids) return {&tile, r};
  }
  check_read(false, "two live tiles do not agree about a cell");
  return {};
}

// Goes from a cell with an own vertex of its tile to the cell across a facet, in a tile of which that has an own
// vertex.
LiveVersion::Place LiveVersion::step(const Place& from, const CellRecord& cell, int facet) const {
  const Place next{from.tile, cell.neighbors[facet] >> 2};
  if (from.tile->has_own(from.tile->row(next.row))) return next;
  auto ids = ids_of(*from.tile, cell);
  int corner = facet == 0 ? 1 : 0;
  if (cell.vertices[corner] == infinite_vertex) corner = facet == 2 ? 1 : 2;
  const PointId opposite = ids[facet], shared = ids[corner];
  const LiveTile& other = *tiles_[from.tile->triangulation().owner(cell.vertices[corner]).value];
  std::sort(ids.begin(), ids.end());
  const Place there = in_other_tile(other, other.triangulation().vertex_of(shared), ids);
  const CellRecord same = other.row(there.row);
  const auto ordered = ids_of(other, same);
  const auto at = std::find(ordered.begin(), ordered.end(), opposite) - ordered.begin();
  return {&other, same.neighbors[at] >> 2};
}

// A cell of the star of the vertex of `cell` that is nearest to p, in the tile of its owner. A foreign vertex may have
// been removed while the tile slept. If all were, a cell of the tile itself.
LiveVersion::Place LiveVersion::true_cell_near(const LiveTile& tile, const CellRecord& cell, const Point& p) const {
  std::optional<std::pair<const LiveTile*, Vertex>> best;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < corners_; ++i) {
    if (cell.vertices[i] == infinite_vertex) continue;
    const Point q = tile.triangulation().kernel().point(cell.vertices[i]);
    const double x = q.x - p.x, y = q.y - p.y, z = q.z - p.z, squared = x * x + y * y + z * z;
    if (best && !(squared < least)) continue;
    const auto& owner = tiles_[tile.triangulation().owner(cell.vertices[i]).value];
    const Vertex v = owner ? owner->triangulation().vertex_of(tile.triangulation().ids()[cell.vertices[i]]) : 0;
    if (v == 0) continue;
    best = {owner.get(), v};
    least = squared;
  }
  if (!best) return {&tile, tile.near(p)};
  return {best->first, best->first->find(best->first->triangulation().kernel().point(best->second))};
}

// The first walk is in the triangulation of one tile. If it ends in a cell that the tile cannot vouch for, a second
// walk goes through cells of the whole triangulation alone.
std::optional<LiveCell> LiveVersion::locate(const Point& p) const {
  const LiveTile& tile = tile_near(p);
  Place place{&tile, tile.find(p)};
  CellRecord cell = tile.row(place.row);
  if (!tile.has_own(cell)) {
    place = true_cell_near(tile, cell, p);
    std::uint32_t random = 0x9e3779b9;
    for (;;) {
      cell = place.tile->row(place.row);
      if (place.tile->infinite(cell)) break;
      const auto facet = place.tile->facet_before(cell, p, random >> 16);
      if (!facet) break;
      random = random * 1664525u + 1013904223u;
      place = step(place, cell, *facet);
    }
  }
  if (place.tile->infinite(cell)) return std::nullopt;
  return this->cell(place);
}

std::optional<std::pair<const LiveTile*, Vertex>> LiveVersion::vertex(PointId id) const {
  const auto tile = ids_.find(id);
  if (!tile || !tiles_[tile->value]) return std::nullopt;
  const LiveTile* there = tiles_[tile->value].get();
  const Vertex v = there->triangulation().vertex_of(id);
  if (v == 0 || !there->triangulation().is_own(v)) return std::nullopt;
  return std::pair(there, v);
}

std::optional<Point> LiveVersion::point(PointId id) const {
  const auto found = vertex(id);
  if (!found) return std::nullopt;
  return found->first->triangulation().kernel().point(found->second);
}

LiveCell LiveVersion::across(const LiveCell& cell, int corner) const {
  const Place here{tiles_[cell.tile.value].get(), cell.row};
  return this->cell(step(here, here.tile->row(here.row), corner));
}

std::optional<std::vector<LiveCell>> LiveVersion::star(PointId id) const {
  const auto found = vertex(id);
  if (!found) return std::nullopt;
  std::vector<LiveCell> out;
  for (const LiveTile::Row r : found->first->star(found->second)) out.push_back(cell({found->first, r}));
  return out;
}

}  // namespace tessera

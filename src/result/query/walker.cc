#include "src/result/query/walker.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::query {
namespace {

template <int d>
int orientation(const std::array<Point, 4>& p) {
  if constexpr (d == 3) {
    return exact::orientation_3(p[0], p[1], p[2], p[3]);
  } else {
    return exact::orientation_2(p[0], p[1], p[2]);
  }
}

// Doubles hold images up to two periods away from those of a tile without rounding. A walk that comes farther goes on
// from the copy of its cell that the tile has.
bool is_near(const PeriodOffset& shift) {
  return std::all_of(shift.by.begin(), shift.by.end(), [](int by) { return -2 <= by && by <= 2; });
}

}  // namespace

Result<const QueryTile*> Walker::tile(TileId id) {
  for (const auto& pinned : pinned_)
    if (pinned->id() == id) return pinned.get();
  BOOST_OUTCOME_TRY(tile, cache_.get(id, with_rows_));
  pinned_.push_back(std::move(tile));
  return pinned_.back().get();
}

void Walker::keep_only(const QueryTile* tile) {
  std::erase_if(pinned_, [&](const PinnedTile& pinned) { return pinned.get() != tile; });
}

Result<CellRef> Walker::across(CellRef from, std::size_t k) {
  const std::int32_t beyond = from.tile->neighbor(from.cell, k);
  if (from.tile->is_part()) {
    met_unknown_ = met_unknown_ || beyond < -1;
    met_unsure_ = met_unsure_ || (beyond >= 0 && !from.tile->is_final(beyond));
    return beyond >= 0 ? CellRef{from.tile, beyond} : CellRef{};
  }
  if (beyond >= 0) return CellRef{from.tile, beyond, from.shift};
  if (beyond == -1) return CellRef{};
  const std::int32_t v = from.tile->vertex(from.cell, k == 0 ? 1 : 0);
  const PointId opposite = from.tile->image(from.tile->vertex(from.cell, k), from.tile->offset(v));
  if (from.tile->mesh().point_ghost[static_cast<std::size_t>(v)] == 0)
    return from.tile->corrupt_cell(from.cell, "has a facet with an own vertex, and an unknown neighbour there");
  BOOST_OUTCOME_TRY(same, same_at(from, v));
  for (std::size_t i = 0; i < same.tile->corners(); ++i) {
    if (same.tile->image(same.tile->vertex(same.cell, i)) != opposite) continue;
    const std::int32_t there = same.tile->neighbor(same.cell, i);
    if (there == -1) return CellRef{};
    if (there >= 0) return CellRef{same.tile, there, same.shift};
  }
  return same.tile->corrupt_cell(same.cell, "has a facet with an own vertex, and an unknown neighbour there");
}

Result<CellRef> Walker::same_in(CellRef place, TileId id) {
  if (place.tile->mesh().offsets.empty()) return copy_in(place, id, {});
  std::optional<PeriodOffset> least;
  for (std::size_t k = 0; k < place.tile->corners(); ++k) {
    const std::int32_t v = place.tile->vertex(place.cell, k);
    if (place.tile->owner(v) != id) continue;
    const PeriodOffset offset = place.tile->offset(v);
    least = least ? std::min(*least, offset) : offset;
  }
  return copy_in(place, id, least.value_or(PeriodOffset{}));
}

Result<CellRef> Walker::same_at(CellRef place, std::int32_t vertex) {
  return copy_in(place, place.tile->owner(vertex), place.tile->offset(vertex));
}

Result<CellRef> Walker::copy_in(CellRef place, TileId id, const PeriodOffset& base) {
  if (place.tile->id() == id && base == PeriodOffset{}) return place;
  BOOST_OUTCOME_TRY(other, tile(id));
  BOOST_OUTCOME_TRY(cell, other->find(place.tile->ids(place.cell, base)));
  if (cell < 0)
    return place.tile->corrupt_cell(place.cell, "is missing in tile " + to_string(id) + ", which owns a vertex of it");
  return CellRef{other, cell, place.shift + base};
}

template <int d>
Result<Located> Walker::walk(const Point& q, CellRef& at) {
  constexpr std::size_t corners = d + 1;
  std::int32_t from = -1;
  for (std::uint64_t steps = 0; steps < steps_max_; ++steps) {
    const QueryTile& tile = *at.tile;
    const std::int32_t* v = &tile.mesh().cells[static_cast<std::size_t>(at.cell) * corners];
    const std::int32_t* n = &tile.mesh().neighbors[static_cast<std::size_t>(at.cell) * corners];
    std::array<Point, 4> p;
    if (tile.period().any()) {
      if (!is_near(at.shift)) at.shift = {};
      for (std::size_t i = 0; i < corners; ++i) p[i] = at.corner(i);
    } else {
      for (std::size_t i = 0; i < corners; ++i) p[i] = tile.point(v[i]);
    }
    std::size_t facet = 0;
    unsigned on_facets = 0;
    for (; facet < corners; ++facet) {
      if (n[facet] == from && from >= 0) continue;  // this facet was crossed, so q is strictly on this side
      const Point corner = std::exchange(p[facet], q);
      const int side = orientation<d>(p);
      p[facet] = corner;
      if (side < 0) break;
      if (side == 0) on_facets |= 1u << facet;
    }
    if (facet == corners) return Located{at, on_facets};
    if (n[facet] == -1) return Located{};
    if (n[facet] >= 0) {
      from = std::exchange(at.cell, n[facet]);
      continue;
    }
    BOOST_OUTCOME_TRY(next, across(at, facet));
    if (!next) return Located{};
    at = next;
    keep_only(at.tile);
    from = -1;
  }
  return at.tile->corrupt_cell(at.cell, "a walk has come here that has no end: the cells are not a triangulation");
}

Result<Located> Walker::choose(const Point& q, const Located& found) {
  CellRef place = found.place;
  std::vector<std::int32_t> corners;  // of the face
  for (std::size_t k = 0; k < place.tile->corners(); ++k)
    if ((found.on_facets >> k & 1u) == 0) corners.push_back(place.tile->vertex(place.cell, k));
  if (corners.empty()) return place.tile->corrupt_cell(place.cell, "has no volume");
  // Prefers an own vertex of this tile, so that no other tile must be read.
  const auto own = std::find_if(corners.begin(), corners.end(), [&](std::int32_t v) {
    return place.tile->mesh().point_ghost[static_cast<std::size_t>(v)] == 0;
  });
  const std::int32_t chosen = own != corners.end() ? *own : corners.back();
  BOOST_OUTCOME_TRY(there, same_at(place, chosen));
  const std::int32_t centre = there.tile->own_vertex(place.tile->id_of(chosen));
  if (centre < 0) return there.tile->corrupt_cell(there.cell, "has vertices with other owners than in another tile");
  BOOST_OUTCOME_TRY(star, there.tile->around(centre));
  std::vector<PointId> face;
  for (const std::int32_t v : corners) face.push_back(place.tile->image(v, place.tile->offset(chosen)));
  std::sort(face.begin(), face.end());
  CellRef best = there;
  CellIds first = there.tile->name(there.cell);
  for (const std::int32_t cell : star) {
    const CellIds ids = there.tile->ids(cell);
    if (!std::includes(ids.begin(), ids.end(), face.begin(), face.end())) continue;
    if (const CellIds name = there.tile->name(cell); name < first) {
      first = name;
      best.cell = cell;
    }
  }
  return Located{best, facets_through(best, q)};
}

Result<Located> Walker::locate(const Point& q, CellRef& from) {
  keep_only(from.tile);
  BOOST_OUTCOME_TRY(found, from.tile->mesh().dimension == 3 ? walk<3>(q, from) : walk<2>(q, from));
  if (!found.place || found.on_facets == 0) return std::move(found);
  return choose(q, found);
}

unsigned facets_through(const CellRef& place, const Point& q) {
  const QueryTile& tile = *place.tile;
  const std::size_t corners = tile.corners();
  std::array<Point, 4> p;
  for (std::size_t i = 0; i < corners; ++i) p[i] = place.corner(i);
  unsigned on = 0;
  for (std::size_t k = 0; k < corners; ++k) {
    const Point corner = std::exchange(p[k], q);
    if ((corners == 4 ? orientation<3>(p) : orientation<2>(p)) == 0) on |= 1u << k;
    p[k] = corner;
  }
  return on;
}

}  // namespace tessera::query

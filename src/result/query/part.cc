#include "src/result/query/part.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <span>
#include <utility>

#include "src/base/on_threads.h"
#include "src/geometry/predicates/exact/predicates.h"

namespace tessera::query {
namespace {

// Puts q in the place of each corner in turn. Returns a value if the closed cell contains q; bit k: q is on the facet
// opposite corner k.
std::optional<unsigned> facets_of(const QueryTile& tile, std::int32_t cell, const Point& q) {
  const std::size_t corners = tile.corners();
  std::array<Point, 4> p;
  for (std::size_t k = 0; k < corners; ++k) p[k] = tile.point(tile.vertex(cell, k));
  unsigned on = 0;
  for (std::size_t k = 0; k < corners; ++k) {
    const Point corner = std::exchange(p[k], q);
    const int side =
        corners == 4 ? exact::orientation_3(p[0], p[1], p[2], p[3]) : exact::orientation_2(p[0], p[1], p[2]);
    p[k] = corner;
    if (side < 0) return std::nullopt;
    if (side == 0) on |= 1u << k;
  }
  return on;
}

}  // namespace

CellTree::CellTree(const QueryTile& tile) {
  const auto cells = tile.mesh().cell_ghost.size();
  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed;
  for (std::size_t c = 0; c < cells; ++c) {
    const auto cell = static_cast<std::int32_t>(c);
    keyed.emplace_back(tile.key(tile.point(tile.vertex(cell, 0))), cell);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<Bounds> boxes;
  for (std::size_t i = 0; i < cells; ++i) {
    order_.push_back(keyed[i].second);
    if (i % leaf_cells == 0) boxes.emplace_back();
    for (std::size_t k = 0; k < tile.corners(); ++k) boxes.back().add(tile.point(tile.vertex(keyed[i].second, k)));
  }
  levels_.push_back(std::move(boxes));
  while (levels_.back().size() > 1) {
    std::vector<Bounds> above;
    for (std::size_t i = 0; i < levels_.back().size(); ++i) {
      if (i % branches == 0) above.emplace_back();
      above.back().add(levels_.back()[i]);
    }
    levels_.push_back(std::move(above));
  }
}

bool CellTree::meet(const Bounds& a, const Bounds& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (a.hi[axis] < b.lo[axis] || b.hi[axis] < a.lo[axis]) return false;
  return true;
}

bool knows(const Manifest& manifest, const Bounds& box) {
  if (!manifest.region) return true;
  if (!manifest.region->complete) return false;
  const Box& known = manifest.region->box;
  for (int axis = 0; axis < manifest.dimension; ++axis)
    if (!(known.lo[axis] <= box.lo[axis] && box.hi[axis] <= known.hi[axis])) return false;
  return true;
}

Located locate_in_part(const Manifest& manifest, const QueryTile& tile, const CellTree& tree, const Point& q) {
  Located found;
  CellIds first{};
  tree.for_each_near({q, q}, [&](std::int32_t cell) {
    const auto on = facets_of(tile, cell, q);
    if (!on) return;
    const CellIds ids = tile.ids(cell);
    if (found.place && !(ids < first)) return;
    first = ids;
    found = {{&tile, cell}, *on};
  });
  // No other cell contains a point in the interior of a cell. On a facet, an unknown cell might come first.
  found.final = knows(manifest, {q, q}) || (found.place && found.on_facets == 0 && tile.is_final(found.place.cell));
  return found;
}

Status locate_all_in_part(TileCache& cache, const Manifest& manifest, const CellTree& tree, const Batch& batch,
                          const VisitLocated& visit) {
  constexpr std::size_t share = 1 << 12;
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  const auto work = [&]() -> Status {
    Walker walker(cache, manifest, batch.with_rows);
    for (std::size_t begin = next.fetch_add(share); begin < batch.points.size() && !failed;
         begin = next.fetch_add(share)) {
      if (batch.stop.stop_requested()) return error(Errc::interrupted, "interrupted while answering");
      BOOST_OUTCOME_TRY(tile, walker.tile(manifest.tiles.front().tile));
      for (std::size_t i = begin; i < std::min(begin + share, batch.points.size()); ++i) {
        BOOST_OUTCOME_TRYV(visit(walker, i, locate_in_part(manifest, *tile, tree, batch.points[i])));
      }
    }
    return success();
  };
  const auto shares = (batch.points.size() + share - 1) / share;
  return on_threads(static_cast<unsigned>(std::clamp<std::size_t>(shares, 1, std::max(batch.threads, 1u))), failed,
                    work);
}

Result<Found> search_part(Walker& walker, const Manifest& manifest, const CellTree& tree, const Area& area,
                          std::uint64_t cells_max, const std::stop_token& stop) {
  Found found;
  const TileId id = manifest.tiles.front().tile;
  BOOST_OUTCOME_TRY(tile, walker.tile(id));
  Bounds box = area.box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lo[axis] = axis < manifest.dimension ? std::max(box.lo[axis], manifest.bounds.lo[axis]) : 0;
    box.hi[axis] = axis < manifest.dimension ? std::min(box.hi[axis], manifest.bounds.hi[axis]) : 0;
    if (box.lo[axis] > box.hi[axis]) return found;
  }
  std::array<Point, 4> corners;
  const double near = nearness(box);
  tree.for_each_near(box, [&](std::int32_t cell) {
    if (found.count > cells_max || stop.stop_requested()) return;
    for (std::size_t k = 0; k < tile->corners(); ++k) corners[k] = tile->point(tile->vertex(cell, k));
    const std::span<const Point> all(corners.data(), tile->corners());
    if (!(area.leg ? meets(all, *area.leg) : meets(all, box))) return;
    if (area.polygon && !area.polygon->meets(all)) return;
    if (area.plane && !meets_plane(all, *area.plane, near)) return;
    found.cells[id].push_back(cell);
    ++found.count;
  });
  if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while looking for cells");
  if (found.count > 0) found.owners.insert(id);
  return found;
}

}  // namespace tessera::query

// The cells of an area are found from the inside. The cells that meet a box are connected through facets that meet the
// box, because the box and the hull are convex. So the search begins with the cells around a few points of the box, and
// goes from neighbour to neighbour inside a tile. The search passes a cell with foreign vertices to the tiles that own
// these vertices, and goes on there. So only tiles with cells that meet the box are read, and a cell is tested once for
// each tile that has it. For a polygon, the search goes through its bounding box. For a line in the plane, the search
// follows the line: its intersection with the hull is connected, too, and so is that of a plane with a box and the
// hull.
#include "src/result/query/search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "src/result/export/cell_filter.h"

namespace tessera::query {

double nearness(const Bounds& bounds) {
  double most = 0;
  for (int axis = 0; axis < 3; ++axis)
    most = std::max({most, std::abs(bounds.lo[axis]), std::abs(bounds.hi[axis]), bounds.hi[axis] - bounds.lo[axis]});
  return most * 1e-13;
}

bool meets_plane(std::span<const Point> cell, const Plane& plane, double near) {
  bool above = false, below = false;
  for (const Point& p : cell) {
    const double height = plane.above(p);
    above = above || height >= -near;
    below = below || height <= near;
  }
  return above && below;
}

namespace {

Bounds cut(const Bounds& box, const Bounds& bounds, int dimension) {
  Bounds both;
  for (int axis = 0; axis < 3; ++axis) {
    both.lo[axis] = axis < dimension ? std::max(box.lo[axis], bounds.lo[axis]) : 0;
    both.hi[axis] = axis < dimension ? std::min(box.hi[axis], bounds.hi[axis]) : 0;
  }
  return both;
}

// The corners of a box, and the midpoints of its edges, its sides and its inside.
std::vector<Point> probes_of(const Bounds& box, int dimension) {
  std::vector<Point> probes;
  for (int i = 0; i < (dimension == 3 ? 27 : 9); ++i) {
    const int step[3] = {i % 3, i / 3 % 3, i / 9};
    Point p;
    for (int axis = 0; axis < dimension; ++axis)
      p[axis] = step[axis] == 0   ? box.lo[axis]
                : step[axis] == 2 ? box.hi[axis]
                                  : std::clamp(box.lo[axis] / 2 + box.hi[axis] / 2, box.lo[axis], box.hi[axis]);
    probes.push_back(without_negative_zero(p));
  }
  return probes;
}

// Points on the line, up to rounding.
std::vector<Point> probes_of(const Leg& leg) {
  std::vector<Point> probes{leg.from, leg.to};
  for (const double part : {0.5, 0.25, 0.75, 0.125, 0.375, 0.625, 0.875})
    probes.push_back(
        without_negative_zero({std::lerp(leg.from.x, leg.to.x, part), std::lerp(leg.from.y, leg.to.y, part), 0}));
  return probes;
}

// Points of the box on the plane, up to rounding, and some points near it.
std::vector<Point> probes_of(const Bounds& box, const Plane& plane) {
  std::vector<Point> probes = probes_of(box, 3);
  for (Point& p : probes) {
    const double above = plane.above(p);
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = std::clamp(p[axis] - above * plane.normal[axis], box.lo[axis], box.hi[axis]);
    p = without_negative_zero(p);
  }
  return probes;
}

// True if all corners of the box are on one side of the plane.
bool is_beside(const Bounds& box, const Plane& plane) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Point p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = (corner >> axis & 1u) != 0 ? box.hi[axis] : box.lo[axis];
    least = std::min(least, plane.above(p));
    most = std::max(most, plane.above(p));
  }
  return least > nearness(box) || most < -nearness(box);
}

class Search {
 public:
  Search(Walker& walker, const Area& area, const Bounds& box, std::uint64_t cells_max, const std::stop_token& stop)
      : walker_(walker), area_(area), box_(box), near_(nearness(box)), cells_max_(cells_max), stop_(stop) {}

  // Begins at this cell. Returns false if the cell does not meet the area.
  bool begin(const CellRef& main) {
    if (!meets_area(*main.tile, main.cell)) return false;
    tiles_[main.tile->id()].waiting.push_back(main.tile->ids(main.cell));
    return true;
  }
  // Tests every cell of the tile.
  Status scan(TileId id) {
    BOOST_OUTCOME_TRY(tile, open(id));
    for (std::int32_t cell = 0; cell < static_cast<std::int32_t>(tile->mesh().cell_ghost.size()); ++cell)
      if (meets_area(*tile, cell)) take(*tile, cell);
    return success();
  }
  Status run() {
    for (auto tile = tiles_.begin(); tile != tiles_.end() && !too_many();) {
      if (tile->second.waiting.empty()) {
        ++tile;
        continue;
      }
      BOOST_OUTCOME_TRYV(spread(tile->first, tile->second));
      tile = tiles_.begin();
    }
    return success();
  }
  bool too_many() const { return found_.count > cells_max_; }
  Found take_found() { return std::move(found_); }

 private:
  struct InTile {
    std::vector<CellIds> waiting;
    std::vector<bool> seen;  // by cell
  };

  Result<const QueryTile*> open(TileId id) {
    if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while looking for cells");
    walker_.keep_only(nullptr);
    return walker_.tile(id);
  }

  std::span<const Point> corners_of(const QueryTile& tile, std::int32_t cell) {
    for (std::size_t k = 0; k < tile.corners(); ++k) corners_[k] = tile.point(tile.vertex(cell, k));
    return {corners_.data(), tile.corners()};
  }
  // For a polygon, tests its bounding box.
  bool meets_area(const QueryTile& tile, std::int32_t cell) {
    const auto corners = corners_of(tile, cell);
    if (area_.leg) return meets(corners, *area_.leg);
    return (!area_.plane || meets_plane(corners, *area_.plane, near_)) && meets(corners, box_);
  }

  // REQUIRES: the cell meets the area.
  void take(const QueryTile& tile, std::int32_t cell) {
    if (tile.mesh().cell_ghost[static_cast<std::size_t>(cell)] != 0) return;
    if (area_.polygon && !area_.polygon->meets(corners_of(tile, cell))) return;
    if (!exports::CellFilter({area_.max_edge, area_.max_radius}).fits(tile.mesh(), static_cast<std::size_t>(cell)))
      return;
    found_.cells[tile.id()].push_back(cell);
    ++found_.count;
    for (std::size_t k = 0; k < tile.corners(); ++k) found_.owners.insert(tile.owner(tile.vertex(cell, k)));
  }

  Status spread(TileId id, InTile& in) {
    BOOST_OUTCOME_TRY(tile, open(id));
    const auto waiting = std::exchange(in.waiting, {});
    in.seen.resize(tile->mesh().cell_ghost.size(), false);
    std::vector<std::int32_t> next;
    const auto look_at = [&](std::int32_t cell) {
      if (in.seen[static_cast<std::size_t>(cell)]) return;
      in.seen[static_cast<std::size_t>(cell)] = true;
      if (meets_area(*tile, cell)) next.push_back(cell);
    };
    for (const CellIds& ids : waiting) {
      if (too_many()) break;
      if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while looking for cells");
      BOOST_OUTCOME_TRY(first, tile->find(ids));
      if (first < 0)
        return error(Errc::corrupt, "tile " + to_string(id) +
                                        " lacks a cell around one of its vertices, which another tile has; the first "
                                        "vertex of the cell is " +
                                        to_string(ids[0]));
      look_at(first);
      while (!next.empty() && !too_many()) {
        const std::int32_t cell = next.back();
        next.pop_back();
        take(*tile, cell);
        tell_owners(*tile, cell);
        for (std::size_t k = 0; k < tile->corners(); ++k)
          if (const std::int32_t beyond = tile->neighbor(cell, k); beyond >= 0) look_at(beyond);
      }
    }
    return success();
  }

  void tell_owners(const QueryTile& tile, std::int32_t cell) {
    std::array<TileId, 4> told{};
    std::size_t n = 0;
    for (std::size_t k = 0; k < tile.corners(); ++k) {
      const TileId owner = tile.owner(tile.vertex(cell, k));
      if (owner == tile.id() || std::find(told.begin(), told.begin() + n, owner) != told.begin() + n) continue;
      told[n++] = owner;
      tiles_[owner].waiting.push_back(tile.ids(cell));
    }
  }

  Walker& walker_;
  const Area& area_;
  Bounds box_;
  double near_;
  std::uint64_t cells_max_;
  const std::stop_token& stop_;
  std::array<Point, 4> corners_;
  std::map<TileId, InTile> tiles_;
  Found found_;
};

}  // namespace

Result<Found> search(Walker& walker, const Homes& homes, const Manifest& manifest, const Area& area,
                     std::uint64_t cells_max, const std::stop_token& stop) {
  const Bounds box = cut(area.box, manifest.bounds, manifest.dimension);
  if (box.lo.x > box.hi.x || box.lo.y > box.hi.y || box.lo.z > box.hi.z) return Found{};
  Search search(walker, area, box, cells_max, stop);
  if (area.plane && is_beside(box, *area.plane)) return Found{};
  for (const Point& probe : area.leg     ? probes_of(*area.leg)
                            : area.plane ? probes_of(box, *area.plane)
                                         : probes_of(box, manifest.dimension)) {
    BOOST_OUTCOME_TRY(tile, walker.tile(homes(probe)));
    std::size_t from = 0;
    CellRef at{tile, tile->start(probe, tile->key(probe), from)};
    BOOST_OUTCOME_TRY(located, walker.locate(probe, at));
    if (!located.place) continue;
    BOOST_OUTCOME_TRY(main, walker.main_place(located.place));
    if (!search.begin(main)) continue;
    BOOST_OUTCOME_TRYV(search.run());
    return search.take_found();
  }
  for (const auto& entry : manifest.tiles) {
    BOOST_OUTCOME_TRYV(search.scan(entry.tile));
    if (search.too_many()) break;
  }
  return search.take_found();
}

}  // namespace tessera::query

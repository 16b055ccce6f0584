// The cells of an area are found from the inside: those that meet a box are connected through facets that meet it, for
// a box and the hull are convex. From the cells around a few of its points on one goes from neighbour to neighbour
// inside a tile. A cell with foreign vertices is told to the tiles that own them; they go on from there. So only tiles
// with cells that meet the box are read, and a cell is tested once a tile that holds it. Of a polygon it is the box
// around it that is searched.
#include <algorithm>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "src/base/option.h"
#include "src/query/impl.h"
#include "src/verify/match_facets.h"

namespace tessera::query {
namespace {

Bounds cut(const Bounds& box, const Bounds& bounds, int dimension) {
  Bounds both;
  for (int axis = 0; axis < 3; ++axis) {
    both.lo[axis] = axis < dimension ? std::max(box.lo[axis], bounds.lo[axis]) : 0;
    both.hi[axis] = axis < dimension ? std::min(box.hi[axis], bounds.hi[axis]) : 0;
  }
  return both;
}

// The corners of a box, and the middles of its edges, sides and inside.
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

class Search {
 public:
  Search(Walker& walker, const Area& area, const Bounds& box, std::uint64_t cells_max, const std::stop_token& stop)
      : walker_(walker), area_(area), box_(box), cells_max_(cells_max), stop_(stop) {}

  // From this cell on, if it meets the box.
  void begin(const Cell& cell) {
    CellIds ids = cell.vertices;
    std::sort(ids.begin(), ids.end());
    tiles_[cell.tile].waiting.push_back(ids);
  }
  // Every cell of the tile is looked at.
  Status scan(TileId id) {
    BOOST_OUTCOME_TRY(tile, open(id));
    for (std::int32_t cell = 0; cell < static_cast<std::int32_t>(tile->mesh().cell_ghost.size()); ++cell)
      if (meets_box(*tile, cell)) take(*tile, cell);
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
  // What was found is not all: it was no use to look any further.
  bool too_many() const { return count_ > cells_max_; }
  std::uint64_t count() const { return count_; }
  // The places of main cells by tile, in no order.
  std::map<TileId, std::vector<std::int32_t>>& found() { return found_; }

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
  bool meets_box(const QueryTile& tile, std::int32_t cell) { return meets(corners_of(tile, cell), box_); }

  // REQUIRES: the cell meets the box.
  void take(const QueryTile& tile, std::int32_t cell) {
    if (tile.mesh().cell_ghost[static_cast<std::size_t>(cell)] != 0) return;
    if (area_.polygon && !area_.polygon->meets(corners_of(tile, cell))) return;
    found_[tile.id()].push_back(cell);
    ++count_;
  }

  Status spread(TileId id, InTile& in) {
    BOOST_OUTCOME_TRY(tile, open(id));
    const auto waiting = std::exchange(in.waiting, {});
    in.seen.resize(tile->mesh().cell_ghost.size(), false);
    std::vector<std::int32_t> next;
    const auto look_at = [&](std::int32_t cell) {
      if (in.seen[static_cast<std::size_t>(cell)]) return;
      in.seen[static_cast<std::size_t>(cell)] = true;
      if (meets_box(*tile, cell)) next.push_back(cell);
    };
    for (const CellIds& ids : waiting) {
      if (too_many()) break;
      if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while looking for cells");
      BOOST_OUTCOME_TRY(first, tile->find(ids));
      if (first < 0)
        return error(Errc::corrupt, "tile " + to_string(id) + " lacks a cell around a vertex of its own, " +
                                        to_string(ids[0]) + " ..., that another tile has");
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
  std::uint64_t cells_max_, count_ = 0;
  const std::stop_token& stop_;
  std::array<Point, 4> corners_;
  std::map<TileId, InTile> tiles_;
  std::map<TileId, std::vector<std::int32_t>> found_;
};

// Copies cells out of tiles, and of their vertices each once.
class Collector {
 public:
  Collector(const Manifest& manifest, std::size_t cells) : row_bytes_(tessera::row_bytes(manifest.schema)) {
    set_.mesh.mesh.dimension = manifest.dimension;
    set_.mesh.schema = manifest.schema;
    set_.tiles.reserve(cells);
  }

  void add(const QueryTile& tile, std::int32_t cell) {
    TileMesh& mesh = set_.mesh.mesh;
    for (std::size_t k = 0; k < tile.corners(); ++k) {
      const std::int32_t v = tile.vertex(cell, k);
      const auto [at, is_new] = numbers_.emplace(tile.id_of(v).value, static_cast<std::int32_t>(mesh.points.size()));
      mesh.cells.push_back(at->second);
      if (!is_new) continue;
      mesh.points.push_back(tile.point(v));
      mesh.ids.push_back(tile.id_of(v));
      mesh.owners.push_back(tile.owner(v));
      mesh.point_ghost.push_back(0);
      if (row_bytes_ > 0) set_.mesh.rows.insert(set_.mesh.rows.end(), tile.row(v), tile.row(v) + row_bytes_);
    }
    mesh.cell_ghost.push_back(0);
    set_.tiles.push_back(tile.id());
  }
  CellSet take() { return std::move(set_); }

 private:
  std::size_t row_bytes_;
  CellSet set_;
  std::unordered_map<std::uint64_t, std::int32_t> numbers_;  // by source index
};

}  // namespace

Result<CellSet> StoredTriangulation::cells(const Area& area, const CellLimits& limits,
                                           const AskOptions& options) const {
  const Manifest& manifest = impl_->manifest;
  const Bounds box = cut(area.box, manifest.bounds, manifest.dimension);
  const bool with_rows = !manifest.schema.empty();
  Walker walker(impl_->cache, manifest, with_rows);
  // A cell with its corners, neighbours and tile, and most likely one vertex or less with its attributes.
  const std::uint64_t bytes_each = 64 + sizeof(Point) + 40 + row_bytes(manifest.schema);
  const std::uint64_t fit = limits.bytes_max / bytes_each;
  Search search(walker, area, box, std::min(limits.cells_max, fit), options.stop);
  const bool apart = box.lo.x > box.hi.x || box.lo.y > box.hi.y || box.lo.z > box.hi.z;
  if (!apart) {
    bool begun = false;
    for (const Point& probe : probes_of(box, manifest.dimension)) {
      BOOST_OUTCOME_TRY(tile, walker.tile(impl_->homes(probe)));
      std::size_t from = 0;
      Place at{tile, tile->start(probe, tile->key(probe), from)};
      BOOST_OUTCOME_TRY(located, walker.locate(probe, at));
      if (!located.place) continue;
      BOOST_OUTCOME_TRY(main, walker.main_place(located.place));
      search.begin(cell_at(main));
      begun = true;
      break;
    }
    if (begun) {
      BOOST_OUTCOME_TRYV(search.run());
    } else {
      for (const auto& entry : manifest.tiles) {
        BOOST_OUTCOME_TRYV(search.scan(entry.tile));
        if (search.too_many()) break;
      }
    }
  }
  if (search.too_many() && limits.cells_max < fit)
    return error(Errc::memory, impl_->out.string() + ": the area has more than " + std::to_string(limits.cells_max) +
                                   " cells, which is the limit: give a smaller area");
  if (search.too_many())
    return error(Errc::memory, impl_->out.string() + ": the area has more than " + std::to_string(fit) +
                                   " cells, which take " + std::to_string(limits.bytes_max >> 20) +
                                   " MiB of memory: give more " + option("memory") + ", or a smaller area");
  Collector collector(manifest, search.count());
  for (auto& [id, cells] : search.found()) {
    walker.keep_only(nullptr);
    BOOST_OUTCOME_TRY(tile, walker.tile(id));
    std::sort(cells.begin(), cells.end());
    for (const std::int32_t cell : cells) collector.add(*tile, cell);
  }
  CellSet set = collector.take();
  BOOST_OUTCOME_TRYV(match_facets(set.mesh.mesh, TileId{0}, impl_->out));
  return set;
}

}  // namespace tessera::query

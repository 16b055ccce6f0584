#include "src/result/query/query_tile.h"

#include <algorithm>
#include <new>
#include <numeric>
#include <string>
#include <unordered_set>

#include "src/base/attribute.h"
#include "src/base/files/names.h"
#include "src/result/verify/match_facets.h"

namespace tessera::query {
namespace {

// The walk from the nearest sample has a few steps. One sample for 60 cells takes a quarter more time; this density
// takes a third of a byte for each cell.
constexpr std::size_t cells_a_sample = 12;

Bounds bounds_of(const TileMesh& mesh) {
  Bounds bounds;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (mesh.point_ghost[v] == 0) bounds.add(mesh.points[v]);
  return bounds;
}

// Used only to choose what is nearer. Infinite differences only make a bad choice.
double squared_distance(const Point& p, const Point& q) {
  const double x = p.x - q.x, y = p.y - q.y, z = p.z - q.z;
  return x * x + y * y + z * z;
}

}  // namespace

Result<std::shared_ptr<const QueryTile>> QueryTile::load(const TileSource& source, std::size_t index, bool with_rows) {
  const auto path = source.file(index);
  try {
    BOOST_OUTCOME_TRY(stored, source.read(index, {.rows = with_rows}));
    if (stored.mesh.cell_ghost.empty()) return error(Errc::corrupt, path.string() + ": has vertices, but no cells");
    if (stored.mesh.neighbors.empty()) {
      BOOST_OUTCOME_TRYV(match_facets(stored.mesh, path));
      // In a region the tile does not tell which facets are on the hull.
      if (source.manifest().region)
        for (auto& neighbor : stored.mesh.neighbors) neighbor = neighbor < 0 ? -2 : neighbor;
    }
    return std::shared_ptr<const QueryTile>(new QueryTile(path, source.entry(index), std::move(stored), source.period(),
                                                          with_rows, source.manifest().region.has_value()));
  } catch (const std::bad_alloc&) {
    return worded([&] { return error(Errc::memory, path.string() + ": no memory is left to hold it"); });
  }
}

QueryTile::QueryTile(std::filesystem::path path, const TileEntry& entry, StoredTile stored, const Period& period,
                     bool with_rows, bool part)
    : path_(std::move(path)),
      id_(entry.tile),
      stored_(std::move(stored)),
      period_(period),
      with_rows_(with_rows),
      part_(part),
      row_bytes_(tessera::row_bytes(stored_.schema)),
      key_(bounds_of(stored_.mesh), stored_.mesh.dimension),
      cell_of_(stored_.mesh.points.size(), -1) {
  const auto cells = static_cast<std::int32_t>(mesh().cell_ghost.size());
  for (std::int32_t c = 0; c < cells; ++c)
    for (std::size_t k = 0; k < corners(); ++k) cell_of_[static_cast<std::size_t>(vertex(c, k))] = c;
  for (std::size_t c = 0; c < static_cast<std::size_t>(cells); c += cells_a_sample) {
    const auto cell = static_cast<std::int32_t>(c);
    samples_.emplace_back(key_(point(vertex(cell, 0))), cell);
  }
  std::sort(samples_.begin(), samples_.end());
  bytes_ = sizeof *this + mesh().bytes() + stored_.rows.size() + samples_.capacity() * sizeof samples_[0] +
           (cell_of_.size() + entry.own_points) * sizeof(std::int32_t);
}

CellIds QueryTile::ids(std::int32_t cell, const PeriodOffset& base) const {
  CellIds ids{no_id, no_id, no_id, no_id};
  for (std::size_t k = 0; k < corners(); ++k) ids[k] = image(vertex(cell, k), base);
  std::sort(ids.begin(), ids.end());
  return ids;
}

TileId QueryTile::main_tile(std::int32_t cell) const {
  TileId least = owner(vertex(cell, 0));
  for (std::size_t k = 1; k < corners(); ++k) least = std::min(least, owner(vertex(cell, k)));
  return least;
}

std::int32_t QueryTile::start(const Point& q, std::uint64_t key, std::size_t& from) const {
  const auto distance = [&](std::size_t sample) {
    return squared_distance(q, point(vertex(samples_[sample].second, 0)));
  };
  // In steps that double, because the next key is mostly near, and the first may be anywhere.
  std::size_t step = 1, end = from;
  while (end < samples_.size() && samples_[end].first < key) {
    from = end;
    end += step;
    step *= 2;
  }
  const auto begin = samples_.begin();
  const auto found = std::lower_bound(begin + static_cast<std::ptrdiff_t>(from),
                                      begin + static_cast<std::ptrdiff_t>(std::min(end, samples_.size())),
                                      std::pair(key, std::int32_t{0}));
  from = static_cast<std::size_t>(found - begin);
  const std::size_t above = std::min(from, samples_.size() - 1), below = above > 0 ? above - 1 : 0;
  return samples_[distance(below) < distance(above) ? below : above].second;
}

std::int32_t QueryTile::own_vertex(PointId id) const {
  std::call_once(by_id_made_, [this] {
    for (std::size_t v = 0; v < mesh().points.size(); ++v)
      if (mesh().point_ghost[v] == 0) by_id_.push_back(static_cast<std::int32_t>(v));
    std::sort(by_id_.begin(), by_id_.end(), [this](std::int32_t a, std::int32_t b) { return id_of(a) < id_of(b); });
  });
  const auto found = std::lower_bound(by_id_.begin(), by_id_.end(), id,
                                      [this](std::int32_t v, PointId wanted) { return id_of(v) < wanted; });
  return found != by_id_.end() && id_of(*found) == id ? *found : -1;
}

// Goes through facets that have the vertex. The tile has all cells of the vertex, and they are connected in this way.
Result<std::vector<std::int32_t>> QueryTile::around(std::int32_t own_vertex) const {
  std::vector<std::int32_t> star;
  const std::int32_t first = cell_of_[static_cast<std::size_t>(own_vertex)];
  if (first < 0)
    return error(Errc::corrupt, path_.string() + ": vertex " + to_string(id_of(own_vertex)) + " has no cell");
  constexpr std::size_t few = 48;  // few enough to search one by one
  std::unordered_set<std::int32_t> seen;
  const auto is_new = [&](std::int32_t cell) {
    if (star.size() < few) return std::find(star.begin(), star.end(), cell) == star.end();
    if (seen.empty()) seen.insert(star.begin(), star.end());
    return seen.insert(cell).second;
  };
  star.push_back(first);
  for (std::size_t done = 0; done < star.size(); ++done) {
    const std::int32_t cell = star[done];
    bool has = false;
    for (std::size_t k = 0; k < corners(); ++k) {
      if (vertex(cell, k) == own_vertex) {
        has = true;
        continue;
      }
      const std::int32_t beyond = neighbor(cell, k);
      if (beyond == -2) return corrupt_cell(cell, "has a facet with an own vertex, and an unknown neighbour there");
      if (beyond >= 0 && is_new(beyond)) star.push_back(beyond);
    }
    if (!has) return corrupt_cell(cell, "is said to be a neighbour across a facet that it does not have");
  }
  return star;
}

Result<std::int32_t> QueryTile::find(const CellIds& wanted) const {
  for (std::size_t k = 0; k < corners(); ++k) {
    const std::int32_t v = own_vertex(wanted[k]);
    if (v < 0) continue;
    BOOST_OUTCOME_TRY(star, around(v));
    for (const std::int32_t cell : star)
      if (ids(cell) == wanted) return cell;
    return -1;
  }
  return error(Errc::corrupt, path_.string() +
                                  ": owns no vertex of a cell that another tile says it has; the first "
                                  "vertex of the cell is " +
                                  to_string(plain(wanted[0])));
}

Error QueryTile::corrupt_cell(std::int32_t cell, const std::string& reason) const {
  return error(Errc::corrupt, path_.string() + ", cell " + std::to_string(cell) + ": " + reason);
}

}  // namespace tessera::query

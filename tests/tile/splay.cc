#include "tests/tile/splay.h"

#include <algorithm>
#include <memory>
#include <random>
#include <set>

#include "src/geometry/kernel/kernel.h"
#include "src/geometry/predicates/independent/predicates.h"
#include "src/tiling/tile/early_finals.h"
#include "src/tiling/tile/rebuild.h"

namespace tessera::testing {
namespace {

struct Update {
  std::uint32_t from, to;
  std::vector<SharedPoint> points;
};

}  // namespace

namespace {

using CellIds = std::vector<std::array<PointId, 4>>;

std::array<PointId, 4> by_id(int corners, const auto& id_of) {
  std::array<PointId, 4> ids{};
  for (int i = 0; i < corners; ++i) ids[static_cast<std::size_t>(i)] = id_of(i);
  std::sort(ids.begin(), ids.begin() + corners);
  return ids;
}

Kernel::TakeVertices tell(CellIds& told, std::span<const PointId> ids, int dimension) {
  return [&told, dimension, ids = std::vector(ids.begin(), ids.end())](std::span<const Vertex> cells) {
    const int corners = dimension + 1;
    for (std::size_t c = 0; c < cells.size(); c += static_cast<std::size_t>(corners)) {
      told.push_back(by_id(corners, [&](int i) { return ids[cells[c + static_cast<std::size_t>(i)]]; }));
    }
  };
}

CellIds main_cells_of(const TileMesh& mesh) {
  const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
  CellIds cells;
  for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
    if (mesh.cell_ghost[c] != 0) continue;
    const std::int32_t* v = &mesh.cells[c * corners];
    cells.push_back(by_id(mesh.dimension + 1, [&](int i) { return mesh.ids[static_cast<std::size_t>(v[i])]; }));
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

TileMesh rebuilt(int dimension, TileId self, std::vector<Point> points, std::vector<PointId> ids,
                 const std::vector<SharedPoint>& foreign) {
  const std::uint64_t own = points.size();
  std::vector<TileId> owners(own, self);
  for (const SharedPoint& p : foreign) {
    points.push_back(p.at);
    ids.push_back(p.id);
    owners.push_back(p.tile);
  }
  auto mesh = rebuild({.dimension = dimension,
                       .self = self,
                       .own = own,
                       .points = std::move(points),
                       .ids = std::move(ids),
                       .owners = std::move(owners)});
  check(mesh.has_value(), "what a tile has left can be rebuilt");
  return std::move(mesh).value();
}

}  // namespace

std::vector<TileMesh> splay(const std::vector<LocalPoint>& points, const std::vector<std::uint32_t>& tile_of,
                            const std::vector<Box>& boxes, const SplayOptions& options) {
  std::mt19937_64 rng(options.seed);
  const std::uint32_t tiles = *std::max_element(tile_of.begin(), tile_of.end()) + 1;
  struct Tile {
    std::vector<Point> points;
    std::vector<PointId> ids;
    PendingFinals finals;
    CellIds told;  // by ids, of cells that were counted
    std::uint64_t counted = 0;
    std::vector<std::int32_t> early_vertices, early_neighbors;
    std::unique_ptr<TileTriangulation> t;
    Bounds bounds;
  };
  std::vector<Tile> tile(tiles);
  for (std::size_t i = 0; i < points.size(); ++i) {
    tile[tile_of[i]].points.push_back(points[i].at);
    tile[tile_of[i]].ids.push_back(points[i].id);
    tile[tile_of[i]].bounds.add(points[i].at);
  }
  std::vector<Bounds> bounds;
  for (const Tile& t : tile) bounds.push_back(t.bounds);
  std::vector<Seed> chosen = make_seeds(points, tile_of, options.dimension, options.announced);
  if (options.rule == ExchangeRule::introduce) add_random_seeds(points, tile_of, rng, chosen);
  std::vector<std::vector<TileId>> neighbours(tiles);
  for (std::uint32_t i = 0; i < tiles && options.announce; ++i) {
    for (std::uint32_t k = 0; k < tiles; ++k) {
      if (k != i && !bounds[k].empty()) neighbours[i].push_back(TileId{k});
    }
  }
  const KnownFromStart around(bounds, std::move(neighbours), std::move(chosen));
  std::vector<Update> mail;
  const auto post = [&](std::uint32_t from) {
    for (auto& [to, list] : tile[from].t->take_updates()) {
      if (!options.single_points) {
        mail.push_back({from, to.value, std::move(list)});
      } else {
        for (const SharedPoint& p : list) mail.push_back({from, to.value, {p}});
      }
    }
  };
  const auto make = [&](std::uint32_t i) {
    return std::make_unique<TileTriangulation>(
        TileOptions{TileId{i}, options.dimension, options.kernel, options.rule, &around});
  };
  std::vector<bool> started(tiles, false);
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < tiles; ++i) order.push_back(i);
  std::shuffle(order.begin(), order.end(), rng);
  const auto start = [&](std::uint32_t i) {
    Tile& self = tile[i];
    self.t = make(i);
    started[i] = true;
    if (self.points.empty()) return;
    const Box nowhere{{1, 1, 1}, {-1, -1, -1}};
    const Box box = boxes.empty() ? nowhere : boxes[i];
    self.t->triangulate(self.points, self.ids);
    if (options.reduce && options.counted) {
      self.counted =
          self.t->discard(self.points, box, rng() % 2 == 0, tell(self.told, self.t->ids(), options.dimension));
    } else if (options.reduce) {
      self.finals.cells = self.t->reduce(self.points, box);
    }
    if (options.early_unit > 0) {
      const EarlyFinals early(options.dimension, self.ids, std::move(self.finals.cells), options.early_unit, {});
      const auto into = [](std::vector<std::int32_t>& list) {
        return [&list](std::span<const std::int32_t> piece) -> Status {
          list.insert(list.end(), piece.begin(), piece.end());
          return success();
        };
      };
      check(early.vertices(into(self.early_vertices)) && early.neighbors(into(self.early_neighbors)), "nobody refuses");
      self.finals = early.left();
      check(self.finals.sound(options.dimension, self.points.size()), "what is left is sound");
    }
    self.t->announce(self.points, box);
    // At once, or with the first mail; without any, when there is nothing else left to do.
    if (options.rule == ExchangeRule::published || rng() % 2 == 0) self.t->introduce();
    post(i);
  };
  std::size_t next = 0;
  const auto introduce_late = [&] {
    for (std::uint32_t i = 0; i < tiles; ++i) {
      if (tile[i].points.empty()) continue;
      tile[i].t->introduce();
      post(i);
    }
    return !mail.empty();
  };
  while (next < order.size() || !mail.empty() || introduce_late()) {
    const std::size_t choice = rng() % (mail.size() + (order.size() - next));
    if (choice >= mail.size()) {
      start(order[next++]);
      continue;
    }
    std::swap(mail[choice], mail.back());
    Update m = std::move(mail.back());
    mail.pop_back();
    if (!started[m.to]) {  // it keeps its mail until it has triangulated
      mail.push_back(std::move(m));
      std::swap(order[next], *std::find(order.begin() + static_cast<std::ptrdiff_t>(next), order.end(), m.to));
      start(order[next++]);
      continue;
    }
    if (options.sleep) {
      const auto bytes = tile[m.to].t->save();
      tile[m.to].t = make(m.to);
      if (!tile[m.to].t->load(bytes)) return {};
    }
    const Status received = tile[m.to].t->receive(TileId{m.from}, m.points);
    check(received.has_value(), "tiles are told of sound points");
    if (options.rule != ExchangeRule::published) tile[m.to].t->introduce();
    post(m.to);
  }
  std::vector<TileMesh> meshes;
  for (Tile& t : tile) {
    if (t.points.empty()) continue;
    if (options.counted) {
      const RestOfTile rest = t.t->collect_rest(tell(t.told, t.t->ids(), options.dimension));
      check(t.counted + rest.main_cells == t.told.size(), "cells are told as often as they are counted");
      meshes.push_back(rebuilt(options.dimension, TileId{static_cast<std::uint32_t>(&t - tile.data())}, t.points, t.ids,
                               rest.foreign));
      const TileMesh& mesh = meshes.back();
      check(mesh.cell_ghost.size() == t.counted + rest.cells, "as many cells as were counted");
      std::sort(t.told.begin(), t.told.end());
      check(t.told == main_cells_of(mesh), "the cells that were told");
    } else {
      meshes.push_back(t.t->collect(t.points, t.ids, std::move(t.finals)).whole(t.early_vertices, t.early_neighbors));
    }
  }
  return meshes;
}

std::string inconsistency(const TileMesh& m, TileId self) {
  const int d = m.dimension, corners = d + 1;
  const auto cells = static_cast<std::int32_t>(m.cell_ghost.size());
  for (std::int32_t c = 0; c < cells; ++c) {
    const std::int32_t* v = &m.cells[static_cast<std::size_t>(c) * corners];
    const std::int32_t* n = &m.neighbors[static_cast<std::size_t>(c) * corners];
    const std::string at = "cell " + std::to_string(c) + ": ";
    const int sign = d == 3 ? independent::orientation_3(m.points[v[0]], m.points[v[1]], m.points[v[2]], m.points[v[3]])
                            : independent::orientation_2(m.points[v[0]], m.points[v[1]], m.points[v[2]]);
    if (sign <= 0) return at + "not positively oriented";
    bool own = false;
    for (int i = 0; i < corners; ++i) {
      const bool here = m.owners[v[i]] == self && (m.offsets.empty() || m.offsets[v[i]] == 0);
      own |= here;
      if (here == (m.point_ghost[v[i]] != 0)) return at + "point ghost flag";
      if (n[i] < -2 || n[i] >= cells) return at + "neighbour out of range";
      if (n[i] < 0) continue;
      const std::int32_t* w = &m.cells[static_cast<std::size_t>(n[i]) * corners];
      std::set<std::int32_t> a(v, v + corners), b(w, w + corners);
      a.erase(v[i]);
      int back = -1;
      for (int k = 0; k < corners; ++k) {
        if (m.neighbors[static_cast<std::size_t>(n[i]) * corners + k] == c) back = k;
      }
      if (back < 0) return at + "neighbour does not know it";
      b.erase(w[back]);
      if (a != b) return at + "facets differ";
    }
    if (!own) return at + "no vertex of its own";
  }
  return "";
}

}  // namespace tessera::testing

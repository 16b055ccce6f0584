#include "src/surface/manifold.h"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace tessera::surface {

namespace {

using Triangle = std::array<std::int32_t, 3>;

const auto of_corner = [](const SplitCorner& c) { return std::tie(c.triangle, c.vertex); };

// A tile's mesh, to which vertices are added.
class Growing {
 public:
  explicit Growing(StoredTile tile) : tile_(std::move(tile)), width_(row_bytes(tile_.schema)) {}

  const StoredTile& tile() const { return tile_; }
  // Adds a vertex with the attributes of `like`, unless one with this id was added.
  std::int32_t add(std::int32_t like, PointId id, const Point& at) {
    const auto found = added_.find(id);
    return found != added_.end() ? found->second : added_[id] = append(like, id, at);
  }

  // Returns those of the triangles that have a vertex of the tile's own, with their vertices, own vertices first.
  StoredTile take(const std::vector<Triangle>& triangles, TileId self) {
    const TileMesh& from = tile_.mesh;
    const auto own = [&](std::int32_t v) { return from.owners[static_cast<std::size_t>(v)] == self; };
    std::vector<Triangle> kept;
    std::vector<std::int32_t> number(from.points.size(), -1);
    for (const Triangle& triangle : triangles) {
      if (std::ranges::none_of(triangle, own)) continue;
      kept.push_back(triangle);
      for (const std::int32_t v : triangle) number[static_cast<std::size_t>(v)] = 0;
    }
    StoredTile out;
    out.schema = tile_.schema;
    out.mesh.dimension = 2;
    for (const bool wanted : {true, false}) {
      for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] < 0 || own(static_cast<std::int32_t>(v)) != wanted) continue;
        number[v] = static_cast<std::int32_t>(out.mesh.points.size());
        out.mesh.points.push_back(from.points[v]);
        out.mesh.ids.push_back(from.ids[v]);
        out.mesh.owners.push_back(from.owners[v]);
        out.mesh.point_ghost.push_back(wanted ? 0 : 1);
        const auto row = std::span(tile_.rows).subspan(v * width_, width_);
        out.rows.insert(out.rows.end(), row.begin(), row.end());
      }
    }
    for (Triangle& triangle : kept)
      for (std::int32_t& v : triangle) v = number[static_cast<std::size_t>(v)];
    put_triangles(std::move(kept), self, out.mesh);
    return out;
  }

 private:
  std::int32_t append(std::int32_t like, PointId id, const Point& at) {
    TileMesh& mesh = tile_.mesh;
    const auto from = static_cast<std::size_t>(like);
    mesh.points.push_back({at.x, at.y, 0});
    mesh.ids.push_back(id);
    mesh.owners.push_back(TileId{mesh.owners[from]});
    mesh.point_ghost.push_back(std::uint8_t{mesh.point_ghost[from]});
    const std::size_t end = tile_.rows.size();
    tile_.rows.resize(end + width_);
    std::memcpy(tile_.rows.data() + end, tile_.rows.data() + from * width_, width_);
    std::memcpy(tile_.rows.data() + end, &at.z, sizeof at.z);
    return static_cast<std::int32_t>(mesh.points.size() - 1);
  }

  StoredTile tile_;
  std::size_t width_;
  std::map<PointId, std::int32_t> added_;
};

// Cuts a triangle into pieces. middles[k] is the vertex in the middle of the edge from corner k to the next corner, or
// -1.
void cut_up(const Triangle& corners, const Triangle& middles, std::vector<Triangle>& out) {
  const auto count = std::ranges::count_if(middles, [](std::int32_t m) { return m >= 0; });
  // Turned so that the first edge has a middle, and the last edge has none if any edge has none.
  std::size_t turn = 0;
  while (count > 0 && count < 3 && !(middles[turn] >= 0 && middles[(turn + 2) % 3] < 0)) ++turn;
  const auto corner = [&](std::size_t k) { return corners[(k + turn) % 3]; };
  const auto middle = [&](std::size_t k) { return middles[(k + turn) % 3]; };
  switch (count) {
    case 0:
      out.push_back(corners);
      return;
    case 1:
      out.push_back({corner(0), middle(0), corner(2)});
      out.push_back({middle(0), corner(1), corner(2)});
      return;
    case 2:
      out.push_back({corner(0), middle(0), corner(2)});
      out.push_back({middle(0), middle(1), corner(2)});
      out.push_back({middle(0), corner(1), middle(1)});
      return;
    default:
      for (std::size_t k = 0; k < 3; ++k) out.push_back({corner(k), middle(k), middle((k + 2) % 3)});
      out.push_back({middle(0), middle(1), middle(2)});
  }
}

}  // namespace

void Manifold::add(Splits splits) {
  const std::lock_guard lock(mutex_);
  corners_.insert(corners_.end(), splits.corners.begin(), splits.corners.end());
  pairs_.insert(pairs_.end(), splits.pairs.begin(), splits.pairs.end());
  for (const CopyPlace& place : splits.places) copies_[{place.vertex, place.copy}] = {{}, place.at};
}

void Manifold::settle(PointId first) {
  std::ranges::sort(corners_, {}, of_corner);
  std::uint64_t next = first.value;
  for (auto& [copy, vertex] : copies_) vertex.id = {next++};

  const auto end_copies = [&](const PairAtEdge& pair) {
    return std::array{copy_of(pair.first, pair.edge[0]), copy_of(pair.first, pair.edge[1])};
  };
  std::ranges::sort(pairs_, {}, [&](const PairAtEdge& p) { return std::tuple(p.edge, end_copies(p), p.first); });
  for (std::size_t i = 1; i < pairs_.size(); ++i) {
    const PairAtEdge &before = pairs_[i - 1], &pair = pairs_[i];
    if (before.edge != pair.edge || end_copies(before) != end_copies(pair)) continue;
    const auto add = [&](const TriangleName& triangle) {
      const auto opposite =
          std::ranges::find_if(triangle, [&](PointId id) { return id != pair.edge[0] && id != pair.edge[1]; });
      middles_.push_back({triangle, *opposite, {{next}, pair.middle}});
    };
    add(pair.first);
    if (pair.second != pair.first) add(pair.second);
    ++next;
  }
  new_vertices_ = next - first.value;
  pairs_ = {};
  std::ranges::sort(middles_, {}, [](const Middle& m) { return std::tie(m.triangle, m.opposite); });
  for (const SplitCorner& corner : corners_) touched_.push_back(corner.triangle);
  for (const Middle& middle : middles_) touched_.push_back(middle.triangle);
  std::ranges::sort(touched_);
  const auto again = std::ranges::unique(touched_);
  touched_.erase(again.begin(), again.end());
}

std::uint32_t Manifold::copy_of(const TriangleName& triangle, PointId vertex) const {
  const auto found = std::ranges::lower_bound(corners_, std::tie(triangle, vertex), {}, of_corner);
  return found != corners_.end() && found->triangle == triangle && found->vertex == vertex ? found->copy : 0;
}

std::optional<Manifold::NewVertex> Manifold::copy_for(const TriangleName& triangle, PointId vertex) const {
  const std::uint32_t copy = copy_of(triangle, vertex);
  if (copy == 0) return std::nullopt;
  return copies_.at({vertex, copy});
}

std::optional<Manifold::NewVertex> Manifold::middle_of(const TriangleName& triangle, PointId opposite) const {
  const auto found = std::ranges::lower_bound(middles_, std::tie(triangle, opposite), {},
                                              [](const Middle& m) { return std::tie(m.triangle, m.opposite); });
  if (found == middles_.end() || found->triangle != triangle || found->opposite != opposite) return std::nullopt;
  return found->vertex;
}

StoredTile Manifold::apply(StoredTile tile, TileId self) const {
  bool touched = false;
  std::vector<Triangle> triangles;
  Growing growing(std::move(tile));
  const std::vector<std::int32_t> cells(growing.tile().mesh.cells.begin(), growing.tile().mesh.cells.end());
  for (std::size_t at = 0; at < cells.size(); at += 3) {
    Triangle corners{cells[at], cells[at + 1], cells[at + 2]};
    const auto id = [&](std::size_t k) { return growing.tile().mesh.ids[static_cast<std::size_t>(cells[at + k % 3])]; };
    const std::array<PointId, 3> ids{id(0), id(1), id(2)};
    TriangleName name = ids;
    std::ranges::sort(name);
    if (!std::ranges::binary_search(touched_, name)) {
      triangles.push_back(corners);
      continue;
    }
    touched = true;
    Triangle middles{-1, -1, -1};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto middle = middle_of(name, ids[(k + 2) % 3]);
      const std::size_t next = (k + 1) % 3;
      if (middle) middles[k] = growing.add(cells[at + (ids[k] < ids[next] ? k : next)], middle->id, middle->at);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (const auto copy = copy_for(name, ids[k])) corners[k] = growing.add(cells[at + k], copy->id, copy->at);
    }
    cut_up(corners, middles, triangles);
  }
  if (!touched) return growing.tile();
  return growing.take(triangles, self);
}

}  // namespace tessera::surface

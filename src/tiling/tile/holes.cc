#include "src/tiling/tile/holes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace tessera {
namespace {

// Sets of removed vertices that edges join.
class JoinedVertices {
 public:
  explicit JoinedVertices(std::size_t vertices) : parents_(vertices) {
    std::iota(parents_.begin(), parents_.end(), std::int32_t{0});
  }
  std::int32_t root(std::int32_t v) {
    while (parents_[v] != v) v = parents_[v] = parents_[parents_[v]];
    return v;
  }
  void join(std::int32_t a, std::int32_t b) { parents_[root(a)] = root(b); }

 private:
  std::vector<std::int32_t> parents_;
};

struct AroundHole {
  std::vector<std::int32_t> vertices;  // some several times
  std::set<TileId> beside;
};

}  // namespace

std::vector<Hole> find_holes(TileId self, const TileMesh& stored, const PointIds& removed) {
  const auto corners = static_cast<std::size_t>(stored.dimension) + 1;
  std::vector<std::uint8_t> gone(stored.ids.size());
  for (std::size_t v = 0; v < gone.size(); ++v) gone[v] = removed.contains(stored.ids[v]) ? 1 : 0;
  const auto is_gone = [&](std::int32_t v) { return gone[v] != 0; };
  JoinedVertices joined(gone.size());
  for (std::size_t at = 0; at < stored.cells.size(); at += corners) {
    const std::int32_t *cell = &stored.cells[at], *first = std::find_if(cell, cell + corners, is_gone);
    for (const std::int32_t* v = first; v != cell + corners; ++v) {
      if (is_gone(*v)) joined.join(*first, *v);
    }
  }
  std::map<std::int32_t, Hole> holes;  // by root
  for (std::size_t v = 0; v < gone.size(); ++v) {
    if (gone[v] != 0 && stored.owners[v] == self)
      holes[joined.root(static_cast<std::int32_t>(v))].removed.push_back(stored.ids[v]);
  }
  std::map<std::int32_t, AroundHole> around;
  for (std::size_t at = 0; at < stored.cells.size(); at += corners) {
    const std::int32_t *cell = &stored.cells[at], *first = std::find_if(cell, cell + corners, is_gone);
    if (first == cell + corners || !holes.contains(joined.root(*first))) continue;
    AroundHole& here = around[joined.root(*first)];
    for (std::size_t i = 0; i < corners; ++i) {
      if (!is_gone(cell[i])) here.vertices.push_back(cell[i]);
      if (stored.owners[cell[i]] != self) here.beside.insert(stored.owners[cell[i]]);
    }
  }
  for (auto& [root, hole] : holes) hole.whole = true;
  for (std::size_t v = 0; v < gone.size(); ++v) {
    if (gone[v] == 0 || stored.owners[v] == self) continue;
    const auto hole = holes.find(joined.root(static_cast<std::int32_t>(v)));
    if (hole != holes.end()) hole->second.whole = false;
  }
  std::vector<Hole> out;
  for (auto& [root, hole] : holes) {
    auto& [vertices, beside] = around[root];
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const std::int32_t v : vertices) hole.around.push_back({stored.points[v], stored.ids[v], stored.owners[v], 0});
    std::sort(hole.around.begin(), hole.around.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    std::sort(hole.removed.begin(), hole.removed.end());
    hole.beside.assign(beside.begin(), beside.end());
    out.push_back(std::move(hole));
  }
  return out;
}

}  // namespace tessera

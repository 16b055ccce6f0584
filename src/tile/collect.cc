#include "src/tile/collect.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "src/base/check.h"

namespace tessera {
namespace {

constexpr std::int32_t outside = -1, elsewhere = -2;

template <int d>
class MeshMaker {
 public:
  explicit MeshMaker(CollectInput input) : in_(std::move(input)) {}

  TileMesh make() {
    mesh_.dimension = d;
    classify();
    number_vertices();
    link_to_others();
    append_final_cells();
    sort_cells();
    write();
    return std::move(mesh_);
  }

 private:
  static constexpr int corners = d + 1;
  enum : std::uint8_t { other, kept, fill };

  // Where the vertices of a cell go in canonical order: the least first, then the least of the rest, by even
  // permutations. `v`: indices into the mesh.
  static std::array<std::uint8_t, corners> canonical(const std::array<std::uint32_t, corners>& v) {
    int least = 0;
    for (int i = 1; i < corners; ++i) least = v[i] < v[least] ? i : least;
    if constexpr (d == 2) {
      constexpr std::uint8_t turns[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}};
      return {turns[least][0], turns[least][1], turns[least][2]};
    } else {
      constexpr std::uint8_t pairs[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};  // two swaps each
      const std::uint8_t* p = pairs[least];
      int second = 1;
      for (int i = 2; i < 4; ++i) second = v[p[i]] < v[p[second]] ? i : second;
      constexpr std::uint8_t turns[4][3] = {{}, {1, 2, 3}, {2, 3, 1}, {3, 1, 2}};
      return {p[0], p[turns[second][0]], p[turns[second][1]], p[turns[second][2]]};
    }
  }

  // The mesh indices of cell c.
  std::array<std::uint32_t, corners> indices(std::size_t c) const {
    std::array<std::uint32_t, corners> v;
    for (int i = 0; i < corners; ++i) {
      const std::uint32_t w = in_.cells.vertices[c * corners + i];
      v[i] = w <= own_ ? w - 1 : index_[w - own_ - 1];
    }
    return v;
  }

  static CellKey facet_key(const std::array<std::uint32_t, corners>& vertices, int opposite) {
    CellKey key{~0u, ~0u, ~0u, ~0u};
    int n = 0;
    for (int i = 0; i < corners; ++i) {
      if (i != opposite) key[n++] = vertices[i];
    }
    std::sort(key.begin(), key.end());
    return key;
  }

  // Cells with a vertex of the tile's own are kept; foreign vertices are used if they are in one.
  void classify() {
    const std::size_t count = in_.cells.vertices.size() / corners;
    held_.resize(count);
    index_.assign(in_.foreign.size(), unused);
    for (std::size_t c = 0; c < count; ++c) {
      const std::uint32_t* v = &in_.cells.vertices[c * corners];
      int own = 0;
      bool finite = true;
      for (int i = 0; i < corners; ++i) {
        own += v[i] - 1 < own_;  // 0 wraps around
        finite &= v[i] != infinite_vertex;
      }
      held_[c] = !finite || own == 0 ? other : !in_.fill.empty() && in_.fill[c] ? fill : kept;
      if (held_[c] != kept || own == corners) continue;
      for (int i = 0; i < corners; ++i) {
        if (v[i] > own_) index_[v[i] - own_ - 1] = 0;
      }
    }
  }

  // Own points by rank, then the used foreign ones by id.
  void number_vertices() {
    std::vector<std::uint32_t> order;
    for (std::uint32_t k = 0; k < index_.size(); ++k) {
      if (index_[k] != unused) order.push_back(k);
    }
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return in_.foreign[a].id < in_.foreign[b].id; });
    const std::size_t n = own_ + order.size();
    mesh_.points.reserve(n);
    mesh_.ids.reserve(n);
    mesh_.points.assign(in_.points.begin(), in_.points.end());
    mesh_.ids.assign(in_.ids.begin(), in_.ids.end());
    mesh_.owners.assign(own_, in_.self.value);
    for (const std::uint32_t k : order) {
      const SharedPoint& p = in_.foreign[k];
      index_[k] = static_cast<std::uint32_t>(mesh_.points.size());
      mesh_.points.push_back(p.at);
      mesh_.ids.push_back(p.id);
      mesh_.owners.push_back(p.tile);
    }
    mesh_.point_ghost.assign(own_, 0);
    mesh_.point_ghost.resize(n, 1);
  }

  // Kept cells know their kept neighbours already. The others, few, tell those of their neighbours that are kept.
  void link_to_others() {
    for (std::size_t c = 0; c < held_.size(); ++c) {
      if (held_[c] == kept) continue;
      const std::uint32_t* v = &in_.cells.vertices[c * corners];
      const bool infinite = std::find(v, v + corners, infinite_vertex) != v + corners;
      for (int i = 0; i < corners; ++i) {
        const std::uint32_t n = in_.cells.neighbors[c * corners + i];
        if (infinite && v[i] == infinite_vertex && held_[n] == fill) {
          // A final cell borders the outside: its facet is one of an infinite cell.
          borders_[facet_key(indices_but(c, i), i)] = {outside, 0};
        }
        if (held_[n] != kept) continue;
        std::uint32_t* back = &in_.cells.neighbors[n * std::size_t{corners}];
        const int k = static_cast<int>(std::find(back, back + corners, c) - back);
        const auto facet = indices_but(n, -1);
        if (held_[c] == fill) {
          borders_[facet_key(facet, k)] = {static_cast<std::int32_t>(n), k};
        } else {
          back[k] = static_cast<std::uint32_t>(infinite && facet_has_own_vertex(facet, k) ? outside : elsewhere);
        }
      }
    }
  }

  // indices(c) for a cell whose vertex `but` may be infinite.
  std::array<std::uint32_t, corners> indices_but(std::size_t c, int but) const {
    std::array<std::uint32_t, corners> v{};
    for (int i = 0; i < corners; ++i) {
      const std::uint32_t w = in_.cells.vertices[c * corners + i];
      if (i != but) v[i] = w <= own_ ? w - 1 : index_[w - own_ - 1];
    }
    return v;
  }

  // What lies across a facet of foreign vertices alone is known to their tiles, not here.
  bool facet_has_own_vertex(const std::array<std::uint32_t, corners>& v, int opposite) const {
    for (int i = 0; i < corners; ++i) {
      if (i != opposite && v[i] < own_) return true;
    }
    return false;
  }

  // Final cells know each other; where one borders a cell of the kernel, their common facet is in borders_.
  void append_final_cells() {
    FinalCells finals = std::exchange(in_.final_cells, {});
    if (finals.vertices.empty()) return;
    const auto shift = static_cast<std::uint32_t>(held_.size());
    const std::size_t count = finals.vertices.size() / corners;
    auto& cells = in_.cells;
    cells.vertices.reserve(cells.vertices.size() + finals.vertices.size());
    for (const std::uint32_t rank : finals.vertices) cells.vertices.push_back(rank + 1);
    finals.vertices = {};
    cells.neighbors.reserve(cells.vertices.size());
    for (std::size_t c = 0; c < count; ++c) {
      for (int i = 0; i < corners; ++i) {
        const std::int32_t n = finals.neighbors[c * corners + i];
        if (n != FinalCells::open) {
          cells.neighbors.push_back(shift + static_cast<std::uint32_t>(n));
          continue;
        }
        const auto border = borders_.find(facet_key(indices(shift + c), i));
        check(border != borders_.end(), "every open facet of a final cell borders a kept cell");
        const auto [cell, opposite] = border->second;
        cells.neighbors.push_back(static_cast<std::uint32_t>(cell));
        if (cell == outside) continue;
        cells.neighbors[static_cast<std::size_t>(cell) * corners + opposite] = shift + static_cast<std::uint32_t>(c);
      }
    }
    held_.resize(shift + count, kept);
  }

  // order_: the kept cells sorted by their canonical vertices. Buckets by the least vertex hold a handful of cells
  // each, and in a bucket the next two vertices tell all apart: a positively oriented cell is the only one on its side
  // of the facet (least, second, third). In 2D, on its side of an edge.
  void sort_cells() {
    std::vector<std::uint32_t> end(mesh_.points.size() + 1, 0);
    const auto least = [&](std::size_t c) {
      const auto v = indices(c);
      return *std::min_element(v.begin(), v.end());
    };
    for (std::size_t c = 0; c < held_.size(); ++c) {
      if (held_[c] == kept) ++end[least(c) + 1];
    }
    std::partial_sum(end.begin(), end.end(), end.begin());
    struct Entry {
      std::uint32_t second, third, cell;
      bool operator<(const Entry& e) const { return second != e.second ? second < e.second : third < e.third; }
    };
    std::vector<Entry> entries(end.back());
    for (std::size_t c = 0; c < held_.size(); ++c) {
      if (held_[c] != kept) continue;
      const auto v = indices(c);
      const auto at = canonical(v);
      entries[end[v[at[0]]]++] = {v[at[1]], v[at[2]], static_cast<std::uint32_t>(c)};
    }
    order_.resize(entries.size());
    std::uint32_t first = 0;
    for (std::size_t v = 0; v + 1 < end.size(); first = end[v++]) {
      const auto begin = entries.begin() + first, stop = entries.begin() + end[v];
      if (stop - begin > 32) {
        std::sort(begin, stop);
      } else {
        for (auto i = begin; i < stop; ++i) {
          const Entry moving = *i;
          auto k = i;
          for (; k > begin && moving < k[-1]; --k) *k = k[-1];
          *k = moving;
        }
      }
      for (std::uint32_t i = first; i < end[v]; ++i) order_[i] = entries[i].cell;
    }
  }

  void write() {
    std::vector<std::int32_t> place(held_.size(), elsewhere);
    for (std::size_t i = 0; i < order_.size(); ++i) place[order_[i]] = static_cast<std::int32_t>(i);
    mesh_.cells.resize(order_.size() * corners);
    mesh_.neighbors.resize(order_.size() * corners);
    mesh_.cell_ghost.resize(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const std::size_t c = order_[k];
      const auto v = indices(c);
      const auto at = canonical(v);
      bool main = true;  // this tile is the lowest of the tiles that own a vertex
      for (int i = 0; i < corners; ++i) {
        const auto n = static_cast<std::int32_t>(in_.cells.neighbors[c * corners + at[i]]);
        mesh_.cells[k * corners + i] = static_cast<std::int32_t>(v[at[i]]);
        mesh_.neighbors[k * corners + i] = n < 0 ? n : place[n];
        main &= v[i] < own_ || mesh_.owners[v[i]] > in_.self.value;
      }
      mesh_.cell_ghost[k] = main ? 0 : 1;
    }
  }

  static constexpr std::uint32_t unused = ~0u;
  CollectInput in_;
  const std::uint32_t own_ = static_cast<std::uint32_t>(in_.points.size());
  TileMesh mesh_;
  std::vector<std::uint8_t> held_;    // by cell
  std::vector<std::uint32_t> index_;  // by k: where foreign vertex k is in the mesh, or unused
  tsl::robin_map<CellKey, std::pair<std::int32_t, int>, CellKeyHash> borders_;  // facet -> (cell or outside, opposite)
  std::vector<std::uint32_t> order_;
};

}  // namespace

TileMesh make_mesh(CollectInput input) {
  return input.dimension == 3 ? MeshMaker<3>(std::move(input)).make() : MeshMaker<2>(std::move(input)).make();
}

}  // namespace tessera

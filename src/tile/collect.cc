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
    number_vertices();
    link_kernel_cells();
    append_final_cells();
    sort_cells();
    write();
    return std::move(mesh_);
  }

 private:
  static constexpr int corners = d + 1;
  // Vertices and neighbours of a cell in canonical order: the least vertex first, then the least of the rest, by even
  // permutations.
  struct Cell {
    std::array<std::uint32_t, corners> vertices;
    std::array<std::uint8_t, corners> from;
  };

  static Cell canonical(const std::uint32_t* v) {
    Cell out;
    int least = 0;
    for (int i = 1; i < corners; ++i) least = v[i] < v[least] ? i : least;
    if constexpr (d == 2) {
      for (int i = 0; i < 3; ++i) out.from[i] = static_cast<std::uint8_t>((least + i) % 3);
    } else {
      constexpr std::uint8_t pairs[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};  // two swaps each
      const std::uint8_t* p = pairs[least];
      int second = 1;
      for (int i = 2; i < 4; ++i) second = v[p[i]] < v[p[second]] ? i : second;
      out.from = {p[0], p[second], p[second % 3 + 1], p[(second + 1) % 3 + 1]};
    }
    for (int i = 0; i < corners; ++i) out.vertices[i] = v[out.from[i]];
    return out;
  }

  static CellKey facet_key(const std::uint32_t* vertices, int opposite) {
    CellKey key{~0u, ~0u, ~0u, ~0u};
    int n = 0;
    for (int i = 0; i < corners; ++i) {
      if (i != opposite) key[n++] = vertices[i];
    }
    std::sort(key.begin(), key.end());
    return key;
  }

  // Own points by rank, then the foreign vertices of held cells by id. in_.place becomes each vertex's index.
  void number_vertices() {
    const std::size_t own = in_.points.size();
    std::vector<std::uint8_t> used(in_.foreign.size(), 0);
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      if (in_.held[c] != CollectInput::kept) continue;
      for (int i = 0; i < corners; ++i) {
        const std::int32_t place = in_.place[in_.cells.vertices[c * corners + i]];
        if (place < 0) used[~place] = 1;
      }
    }
    std::vector<std::uint32_t> order;
    for (std::uint32_t k = 0; k < used.size(); ++k) {
      if (used[k]) order.push_back(k);
    }
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return in_.foreign[a].id < in_.foreign[b].id; });
    const std::size_t n = own + order.size();
    mesh_.points.reserve(n);
    mesh_.ids.reserve(n);
    mesh_.points.assign(in_.points.begin(), in_.points.end());
    mesh_.ids.assign(in_.ids.begin(), in_.ids.end());
    mesh_.owners.assign(own, in_.self.value);
    std::vector<std::int32_t> index(in_.foreign.size(), -1);
    for (const std::uint32_t k : order) {
      const SharedPoint& p = in_.foreign[k];
      index[k] = static_cast<std::int32_t>(mesh_.points.size());
      mesh_.points.push_back(p.at);
      mesh_.ids.push_back(p.id);
      mesh_.owners.push_back(p.tile);
    }
    for (std::int32_t& place : in_.place) {
      if (place < 0) place = index[~place];
    }
    mesh_.point_ghost.assign(own, 0);
    mesh_.point_ghost.resize(n, 1);
  }

  bool is_own(std::uint32_t vertex_index) const { return vertex_index < in_.points.size(); }

  // In place: vertices become indices into the mesh; neighbours stay places in this list, or say outside or elsewhere.
  void link_kernel_cells() {
    auto& cells = in_.cells;
    infinite_.resize(in_.held.size(), 0);
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      for (int i = 0; i < corners; ++i) {
        std::uint32_t& v = cells.vertices[c * corners + i];
        if (v == infinite_vertex) infinite_[c] = static_cast<std::uint8_t>(i + 1);
        v = static_cast<std::uint32_t>(in_.place[v]);
      }
    }
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      const std::uint32_t* v = &cells.vertices[c * corners];
      std::uint32_t* n = &cells.neighbors[c * corners];
      if (infinite_[c]) {  // a final cell may border the outside: its facet is then one of an infinite cell
        const int i = infinite_[c] - 1;
        if (in_.held[n[i]] == CollectInput::fill) borders_[facet_key(v, i)] = {outside, 0};
      }
      if (in_.held[c] != CollectInput::kept) continue;
      for (int i = 0; i < corners; ++i) {
        switch (in_.held[n[i]]) {
          case CollectInput::kept:
            break;
          case CollectInput::fill:
            borders_[facet_key(v, i)] = {static_cast<std::int32_t>(c), i};
            break;
          default:
            n[i] = static_cast<std::uint32_t>(infinite_[n[i]] && facet_has_own_vertex(v, i) ? outside : elsewhere);
        }
      }
    }
  }

  // What lies across a facet of foreign vertices alone is known to their tiles, not here.
  bool facet_has_own_vertex(const std::uint32_t* v, int opposite) const {
    for (int i = 0; i < corners; ++i) {
      if (i != opposite && is_own(v[i])) return true;
    }
    return false;
  }

  // Final cells know each other; where one borders a cell of the kernel, their common facet is in borders_.
  void append_final_cells() {
    FinalCells finals = std::exchange(in_.final_cells, {});
    if (finals.vertices.empty()) return;
    auto& cells = in_.cells;
    const auto shift = static_cast<std::uint32_t>(in_.held.size());
    const std::size_t count = finals.vertices.size() / corners;
    cells.vertices.insert(cells.vertices.end(), finals.vertices.begin(), finals.vertices.end());
    finals.vertices = {};
    cells.neighbors.reserve(cells.vertices.size());
    for (std::size_t c = 0; c < count; ++c) {
      for (int i = 0; i < corners; ++i) {
        const std::int32_t n = finals.neighbors[c * corners + i];
        if (n != FinalCells::open) {
          cells.neighbors.push_back(shift + static_cast<std::uint32_t>(n));
          continue;
        }
        const auto border = borders_.find(facet_key(&cells.vertices[(shift + c) * corners], i));
        check(border != borders_.end(), "every open facet of a final cell borders a kept cell");
        const auto [cell, opposite] = border->second;
        cells.neighbors.push_back(static_cast<std::uint32_t>(cell));
        if (cell != outside) cells.neighbors[cell * corners + opposite] = shift + static_cast<std::uint32_t>(c);
      }
    }
    in_.held.resize(shift + count, CollectInput::kept);
  }

  // order_: the cells sorted by their canonical vertices. Buckets by the least vertex hold a handful of cells each.
  void sort_cells() {
    std::vector<std::uint32_t> begin(mesh_.points.size() + 1, 0);
    const auto least = [&](std::size_t c) {
      const std::uint32_t* v = &in_.cells.vertices[c * corners];
      return *std::min_element(v, v + corners);
    };
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      if (in_.held[c] == CollectInput::kept) ++begin[least(c) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    order_.resize(begin.back());
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      if (in_.held[c] == CollectInput::kept) order_[begin[least(c)]++] = static_cast<std::uint32_t>(c);
    }
    // begin[v] is now the end of bucket v.
    std::vector<std::pair<Cell, std::uint32_t>> bucket;
    std::uint32_t first = 0;
    for (std::size_t v = 0; v + 1 < begin.size(); first = begin[v++]) {
      if (begin[v] - first < 2) continue;
      bucket.clear();
      for (std::uint32_t i = first; i < begin[v]; ++i) {
        bucket.emplace_back(canonical(&in_.cells.vertices[order_[i] * std::size_t{corners}]), order_[i]);
      }
      std::sort(bucket.begin(), bucket.end(), [](const auto& a, const auto& b) { return a.first.vertices < b.first.vertices; });
      for (std::uint32_t i = first; i < begin[v]; ++i) order_[i] = bucket[i - first].second;
    }
  }

  void write() {
    std::vector<std::int32_t> place(in_.held.size(), elsewhere);
    for (std::size_t i = 0; i < order_.size(); ++i) place[order_[i]] = static_cast<std::int32_t>(i);
    mesh_.cells.resize(order_.size() * corners);
    mesh_.neighbors.resize(order_.size() * corners);
    mesh_.cell_ghost.resize(order_.size());
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const std::uint32_t c = order_[k];
      const Cell cell = canonical(&in_.cells.vertices[c * std::size_t{corners}]);
      bool main = true;  // this tile is the lowest of the tiles that own a vertex
      for (int i = 0; i < corners; ++i) {
        const std::uint32_t v = cell.vertices[i];
        const auto n = static_cast<std::int32_t>(in_.cells.neighbors[c * std::size_t{corners} + cell.from[i]]);
        mesh_.cells[k * corners + i] = static_cast<std::int32_t>(v);
        mesh_.neighbors[k * corners + i] = n < 0 ? n : place[n];
        main &= is_own(v) || mesh_.owners[v] > in_.self.value;
      }
      mesh_.cell_ghost[k] = main ? 0 : 1;
    }
  }

  CollectInput in_;
  TileMesh mesh_;
  std::vector<std::uint8_t> infinite_;  // by kernel cell: 1 + the place of the infinite vertex, or 0
  tsl::robin_map<CellKey, std::pair<std::int32_t, int>, CellKeyHash> borders_;  // facet -> (cell or outside, opposite)
  std::vector<std::uint32_t> order_;
};

}  // namespace

TileMesh make_mesh(CollectInput input) {
  return input.dimension == 3 ? MeshMaker<3>(std::move(input)).make() : MeshMaker<2>(std::move(input)).make();
}

}  // namespace tessera

#include "src/tile/collect.h"

#include <tsl/robin_map.h>

#include <algorithm>
#include <array>
#include <limits>
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
    bucket_cells();
    write_cells();
    finish_neighbors();
    return std::move(mesh_);
  }

 private:
  static constexpr int corners = d + 1;
  enum : std::uint8_t { gap, other, kept, fill };

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
      const std::uint32_t w = in_.cells[c].vertices[i];
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
    const std::size_t count = in_.cells.size();
    held_.resize(count);
    index_.assign(in_.foreign.size(), unused);
    for (std::size_t c = 0; c < count; ++c) {
      const std::uint32_t* v = in_.cells[c].vertices;
      if (v[0] == CellRow::gap) {
        held_[c] = gap;
        continue;
      }
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
    mesh_.owners.assign(own_, in_.self);
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
      if (held_[c] == kept || held_[c] == gap) continue;
      const std::uint32_t* v = in_.cells[c].vertices;
      const bool infinite = std::find(v, v + corners, infinite_vertex) != v + corners;
      for (int i = 0; i < corners; ++i) {
        const std::uint32_t n = in_.cells[c].neighbors[i];
        if (n & across_frozen) continue;
        if (infinite && v[i] == infinite_vertex && held_[n] == fill) {
          // A final cell borders the outside: its facet is one of an infinite cell.
          borders_[facet_key(indices_but(c, i), i)] = {outside, 0};
        }
        if (held_[n] != kept) continue;
        std::uint32_t* back = in_.cells[n].neighbors;
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
      const std::uint32_t w = in_.cells[c].vertices[i];
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

  // Final cells know each other. What else they border is known to a kernel that froze them; where the kernel was built
  // again, their common facets are in borders_.
  void append_final_cells() {
    FinalCells finals = std::exchange(in_.final_cells, {});
    if (finals.vertices.empty()) return;
    const auto shift = static_cast<std::uint32_t>(held_.size());
    const std::size_t count = finals.vertices.size() / corners;
    CellRows& cells = in_.cells;
    for (std::size_t c = 0; c < held_.size(); ++c) {
      if (held_[c] == gap) continue;
      for (int i = 0; i < corners; ++i) {
        std::uint32_t& n = cells[c].neighbors[i];
        if (n >= first_code || !(n & across_frozen)) continue;
        const std::uint32_t facet = n & ~across_frozen;
        check(facet < finals.neighbors.size() && finals.neighbors[facet] == FinalCells::open,
              "a facet of the hole is one of a final cell");
        finals.neighbors[facet] = held_[c] == kept ? -static_cast<std::int32_t>(c) - 2 : bordering_outside;
        n = shift + facet / corners;
      }
    }
    cells.resize(shift + count);
    for (std::size_t c = 0; c < count; ++c) {
      CellRow& row = cells[shift + c];
      for (int i = 0; i < corners; ++i) row.vertices[i] = finals.vertices[c * corners + i] + 1;
      for (int i = 0; i < corners; ++i) {
        const std::int32_t n = finals.neighbors[c * corners + i];
        if (n >= 0) {
          row.neighbors[i] = shift + static_cast<std::uint32_t>(n);
        } else if (n != FinalCells::open) {
          row.neighbors[i] = static_cast<std::uint32_t>(n == bordering_outside ? outside : -(n + 2));
        } else {
          const auto border = borders_.find(facet_key(indices(shift + c), i));
          check(border != borders_.end(), "every open facet of a final cell borders a kept cell");
          const auto [cell, opposite] = border->second;
          row.neighbors[i] = static_cast<std::uint32_t>(cell);
          if (cell != outside) cells[cell].neighbors[opposite] = shift + static_cast<std::uint32_t>(c);
        }
      }
    }
    held_.resize(shift + count, kept);
  }

  // order_: the kept cells by their least vertex, which is one of the tile's own: these come first.
  void bucket_cells() {
    end_.assign(std::size_t{own_} + 1, 0);
    const auto least = [&](std::size_t c) {
      const std::uint32_t* v = in_.cells[c].vertices;
      return *std::min_element(v, v + corners) - 1;
    };
    for (std::size_t c = 0; c < held_.size(); ++c) {
      if (held_[c] == kept) ++end_[least(c) + 1];
    }
    std::partial_sum(end_.begin(), end_.end(), end_.begin());
    order_.resize(end_.back());
    for (std::size_t c = 0; c < held_.size(); ++c) {
      if (held_[c] == kept) order_[end_[least(c)]++] = static_cast<std::uint32_t>(c);
    }
  }

  struct Entry {
    std::array<std::uint32_t, corners> v;  // canonical
    std::array<std::uint32_t, corners> n;  // beside it
    std::uint32_t cell;
    // In a bucket the next two vertices tell all cells apart: a positively oriented cell is the only one on its side of
    // the facet (least, second, third). In 2D, on its side of an edge.
    std::uint64_t key() const { return std::uint64_t{v[1]} << 32 | v[2]; }
  };

  Entry entry(std::uint32_t c) const {
    Entry e;
    e.cell = c;
    const auto v = indices(c);
    const auto at = canonical(v);
    for (int i = 0; i < corners; ++i) {
      e.v[i] = v[at[i]];
      e.n[i] = in_.cells[c].neighbors[at[i]];
    }
    return e;
  }

  // Neighbours are written as they come, to be told their places at the end.
  void write_cells() {
    place_.assign(held_.size(), elsewhere);
    mesh_.cells.resize(order_.size() * corners);
    mesh_.neighbors.resize(order_.size() * corners);
    mesh_.cell_ghost.resize(order_.size());
    std::vector<Entry> bucket;
    std::vector<std::uint64_t> keys;
    std::uint32_t k = 0;
    for (std::uint32_t v = 0; v < own_; ++v) {
      bucket.clear();
      keys.clear();
      for (std::uint32_t i = k; i < end_[v]; ++i) {
        prefetch_cell(i + 32);
        bucket.push_back(entry(order_[i]));
        keys.push_back(bucket.back().key());
      }
      if (bucket.size() > 64) {
        std::sort(bucket.begin(), bucket.end(), [](const Entry& a, const Entry& b) { return a.key() < b.key(); });
        for (const Entry& e : bucket) write_cell(k++, e);
        continue;
      }
      // A handful most times: counting the smaller ones has no branch to be guessed wrong.
      for (const Entry& e : bucket) {
        std::uint32_t smaller = 0;
        const std::uint64_t key = e.key();
        for (const std::uint64_t other : keys) smaller += other < key;
        write_cell(k + smaller, e);
      }
      k = end_[v];
    }
  }

  void write_cell(std::uint32_t k, const Entry& e) {
    bool main = true;  // this tile is the lowest of the tiles that own a vertex
    for (int i = 0; i < corners; ++i) {
      mesh_.cells[std::size_t{k} * corners + i] = static_cast<std::int32_t>(e.v[i]);
      mesh_.neighbors[std::size_t{k} * corners + i] = static_cast<std::int32_t>(e.n[i]);
      main &= e.v[i] < own_ || mesh_.owners[e.v[i]] > in_.self;
    }
    mesh_.cell_ghost[k] = main ? 0 : 1;
    place_[e.cell] = static_cast<std::int32_t>(k);
  }

  // Cells in canonical order are anywhere in the input: ask for those that come soon.
  void prefetch_cell(std::uint32_t i) const {
    if (i < order_.size()) __builtin_prefetch(&in_.cells[order_[i]]);
  }

  void finish_neighbors() {
    const std::size_t count = mesh_.neighbors.size();
    constexpr std::size_t ahead = 64;
    for (std::size_t i = 0; i < count; ++i) {
      if (i + ahead < count && mesh_.neighbors[i + ahead] >= 0) __builtin_prefetch(&place_[mesh_.neighbors[i + ahead]]);
      std::int32_t& n = mesh_.neighbors[i];
      if (n >= 0) n = place_[n];
    }
  }

  static constexpr std::uint32_t unused = ~0u;
  static constexpr std::uint32_t first_code = static_cast<std::uint32_t>(elsewhere);  // elsewhere and outside
  static constexpr std::int32_t bordering_outside = std::numeric_limits<std::int32_t>::min();
  CollectInput in_;
  const std::uint32_t own_ = static_cast<std::uint32_t>(in_.points.size());
  TileMesh mesh_;
  BigVector<std::uint8_t> held_;      // by cell
  std::vector<std::uint32_t> index_;  // by k: where foreign vertex k is in the mesh, or unused
  tsl::robin_map<CellKey, std::pair<std::int32_t, int>, CellKeyHash> borders_;  // facet -> (cell or outside, opposite)
  BigVector<std::uint32_t> order_;
  BigVector<std::uint32_t> end_;   // by own vertex: where its bucket ends in order_
  BigVector<std::int32_t> place_;  // by cell: where it is in the mesh
};

}  // namespace

TileMesh make_mesh(CollectInput input) {
  return input.dimension == 3 ? MeshMaker<3>(std::move(input)).make() : MeshMaker<2>(std::move(input)).make();
}

}  // namespace tessera

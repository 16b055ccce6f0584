#include "src/tile/collect.h"

#include <algorithm>
#include <array>

#include <tsl/robin_map.h>

#include "src/base/check.h"

namespace tessera {
namespace {

constexpr std::int32_t outside = -1, elsewhere = -2;

struct Cell {
  std::array<std::int32_t, 4> vertices, neighbors;
};

CellKey facet_key(const std::int32_t* vertices, int opposite, int dimension) {
  CellKey key{~0u, ~0u, ~0u, ~0u};
  int n = 0;
  for (int i = 0; i <= dimension; ++i) {
    if (i != opposite) key[n++] = static_cast<std::uint32_t>(vertices[i]);
  }
  std::sort(key.begin(), key.end());
  return key;
}

// Brings the least vertex to the front and the least of the rest behind it, by even permutations. In 2D: a rotation.
void make_canonical(Cell& cell, int dimension) {
  auto& v = cell.vertices;
  auto& n = cell.neighbors;
  const int corners = dimension + 1;
  const int least = static_cast<int>(std::min_element(v.begin(), v.begin() + corners) - v.begin());
  if (dimension == 2) {
    std::rotate(v.begin(), v.begin() + least, v.begin() + 3);
    std::rotate(n.begin(), n.begin() + least, n.begin() + 3);
    return;
  }
  if (least != 0) {  // swap two pairs: even
    const int a = least == 1 ? 2 : 1, b = least == 3 ? 2 : 3;
    std::swap(v[0], v[least]);
    std::swap(n[0], n[least]);
    std::swap(v[a], v[b]);
    std::swap(n[a], n[b]);
  }
  const int second = static_cast<int>(std::min_element(v.begin() + 1, v.end()) - v.begin());
  std::rotate(v.begin() + 1, v.begin() + second, v.end());
  std::rotate(n.begin() + 1, n.begin() + second, n.end());
}

// Sorts cells by their vertices; returns where each went. Buckets by the first vertex hold a handful of cells each.
std::vector<std::int32_t> sort_cells(std::vector<Cell>& cells, std::size_t vertices, int corners) {
  std::vector<std::uint32_t> begin(vertices + 1, 0);
  for (const Cell& c : cells) ++begin[c.vertices[0] + 1];
  for (std::size_t v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
  std::vector<std::uint32_t> order(cells.size()), next(begin.begin(), begin.end() - 1);
  for (std::size_t c = 0; c < cells.size(); ++c) order[next[cells[c].vertices[0]]++] = static_cast<std::uint32_t>(c);
  const auto less = [&](std::uint32_t a, std::uint32_t b) {
    const auto &p = cells[a].vertices, &q = cells[b].vertices;
    return std::lexicographical_compare(p.begin() + 1, p.begin() + corners, q.begin() + 1, q.begin() + corners);
  };
  for (std::size_t v = 0; v < vertices; ++v) std::sort(order.begin() + begin[v], order.begin() + begin[v + 1], less);
  std::vector<std::int32_t> place(cells.size());
  std::vector<Cell> sorted(cells.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    sorted[i] = cells[order[i]];
    place[order[i]] = static_cast<std::int32_t>(i);
  }
  cells = std::move(sorted);
  return place;
}

class MeshMaker {
 public:
  explicit MeshMaker(CollectInput input)
      : in_(std::move(input)), d_(in_.dimension), corners_(in_.dimension + 1) {}

  TileMesh make() {
    number_vertices();
    add_kernel_cells();
    in_.cells = {};
    add_final_cells();
    in_.final_cells = {};
    for (Cell& c : cells_) make_canonical(c, d_);
    const std::vector<std::int32_t> place = sort_cells(cells_, mesh_.points.size(), corners_);
    write(place);
    return std::move(mesh_);
  }

 private:
  // Own points by rank, then the foreign vertices of held cells by id.
  void number_vertices() {
    mesh_.dimension = d_;
    mesh_.points.assign(in_.points.begin(), in_.points.end());
    mesh_.ids.assign(in_.ids.begin(), in_.ids.end());
    index_.assign(in_.vertices.size(), -1);
    std::vector<Vertex> foreign;
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      if (in_.held[c] != CollectInput::kept) continue;
      for (int i = 0; i < corners_; ++i) {
        const Vertex v = in_.cells.vertices[c * corners_ + i];
        if (in_.vertices[v].owner == in_.self.value || index_[v] == 0) continue;
        index_[v] = 0;
        foreign.push_back(v);
      }
    }
    std::sort(foreign.begin(), foreign.end(),
              [&](Vertex a, Vertex b) { return in_.vertices[a].id < in_.vertices[b].id; });
    for (Vertex v = 1; v < in_.vertices.size(); ++v) {
      if (in_.vertices[v].owner == in_.self.value) index_[v] = static_cast<std::int32_t>(in_.vertices[v].rank);
    }
    mesh_.owners.assign(mesh_.points.size(), in_.self.value);
    for (const Vertex v : foreign) {
      index_[v] = static_cast<std::int32_t>(mesh_.points.size());
      mesh_.points.push_back(in_.vertices[v].at);
      mesh_.ids.push_back(in_.vertices[v].id);
      mesh_.owners.push_back(in_.vertices[v].owner);
    }
    mesh_.point_ghost.assign(in_.points.size(), 0);
    mesh_.point_ghost.resize(mesh_.points.size(), 1);
  }

  void add_kernel_cells() {
    std::vector<std::int32_t> number(in_.held.size(), elsewhere);
    std::int32_t kept = 0;
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      if (in_.held[c] == CollectInput::kept) number[c] = kept++;
    }
    cells_.reserve(kept + in_.final_cells.vertices.size() / corners_);
    for (std::size_t c = 0; c < in_.held.size(); ++c) {
      const Vertex* v = &in_.cells.vertices[c * corners_];
      if (in_.held[c] != CollectInput::kept) {
        note_hull_facet(c);
        continue;
      }
      Cell cell{};
      for (int i = 0; i < corners_; ++i) cell.vertices[i] = index_[v[i]];
      for (int i = 0; i < corners_; ++i) {
        const std::uint32_t across = in_.cells.neighbors[c * corners_ + i];
        cell.neighbors[i] = number[across];
        if (in_.held[across] == CollectInput::fill) {
          borders_[facet_key(cell.vertices.data(), i, d_)] = {static_cast<std::int32_t>(cells_.size()), i};
        } else if (cell.neighbors[i] == elsewhere && is_outside(across) && facet_is_certain(v, i)) {
          cell.neighbors[i] = outside;
        }
      }
      cells_.push_back(cell);
    }
  }

  // A final cell may border the outside: its facet is then one of an infinite cell.
  void note_hull_facet(std::size_t c) {
    const Vertex* v = &in_.cells.vertices[c * corners_];
    const auto infinite = std::find(v, v + corners_, infinite_vertex) - v;
    if (infinite == corners_ || in_.held[in_.cells.neighbors[c * corners_ + infinite]] != CollectInput::fill) return;
    std::array<std::int32_t, 4> corner{};
    for (int i = 0; i < corners_; ++i) corner[i] = index_[v[i]];
    borders_[facet_key(corner.data(), static_cast<int>(infinite), d_)] = {outside, 0};
  }

  bool is_outside(std::uint32_t c) const {
    const Vertex* v = &in_.cells.vertices[c * static_cast<std::size_t>(corners_)];
    return std::find(v, v + corners_, infinite_vertex) != v + corners_;
  }

  // What lies across a facet of foreign vertices alone is known to their tiles, not here.
  bool facet_is_certain(const Vertex* v, int opposite) const {
    for (int i = 0; i < corners_; ++i) {
      if (i != opposite && in_.vertices[v[i]].owner == in_.self.value) return true;
    }
    return false;
  }

  // Final cells know each other; where one borders a cell of the kernel, their common facet is in borders_.
  void add_final_cells() {
    const auto& finals = in_.final_cells;
    const auto shift = static_cast<std::int32_t>(cells_.size());
    for (std::size_t c = 0; c < finals.vertices.size() / corners_; ++c) {
      Cell cell{};
      for (int i = 0; i < corners_; ++i) cell.vertices[i] = static_cast<std::int32_t>(finals.vertices[c * corners_ + i]);
      for (int i = 0; i < corners_; ++i) {
        const std::int32_t n = finals.neighbors[c * corners_ + i];
        if (n != FinalCells::open) {
          cell.neighbors[i] = shift + n;
          continue;
        }
        const auto border = borders_.find(facet_key(cell.vertices.data(), i, d_));
        check(border != borders_.end(), "every open facet of a final cell borders a kept cell");
        cell.neighbors[i] = border->second.first;
        if (border->second.first == outside) continue;
        cells_[border->second.first].neighbors[border->second.second] = shift + static_cast<std::int32_t>(c);
      }
      cells_.push_back(cell);
    }
  }

  void write(const std::vector<std::int32_t>& place) {
    mesh_.cells.reserve(cells_.size() * corners_);
    mesh_.neighbors.reserve(cells_.size() * corners_);
    mesh_.cell_ghost.reserve(cells_.size());
    for (const Cell& c : cells_) {
      bool main = true;  // this tile is the lowest of the tiles that own a vertex
      for (int i = 0; i < corners_; ++i) {
        mesh_.cells.push_back(c.vertices[i]);
        mesh_.neighbors.push_back(c.neighbors[i] < 0 ? c.neighbors[i] : place[c.neighbors[i]]);
        main &= mesh_.owners[c.vertices[i]] >= in_.self.value;
      }
      mesh_.cell_ghost.push_back(main ? 0 : 1);
    }
  }

  CollectInput in_;
  const int d_, corners_;
  TileMesh mesh_;
  std::vector<std::int32_t> index_;  // by vertex: its place in the mesh
  std::vector<Cell> cells_;
  tsl::robin_map<CellKey, std::pair<std::int32_t, int>, CellKeyHash> borders_;  // facet -> (cell or outside, opposite vertex)
};

}  // namespace

TileMesh make_mesh(CollectInput input) { return MeshMaker(std::move(input)).make(); }

}  // namespace tessera

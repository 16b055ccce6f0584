#include "tests/kernel/differential.h"

#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <utility>

#include "src/geometry/kernel/flat/flat_kernel.h"
#include "src/geometry/predicates/independent/predicates.h"
#include "src/tiling/tile/circumsphere.h"

namespace tessera::testing {
namespace {

using Corners = std::array<Vertex, 4>;  // of a cell, ascending; triangles end with no_vertex
constexpr Vertex no_vertex = ~0u;

Corners sorted(const Vertex* v, std::size_t corners) {
  Corners c;
  c.fill(no_vertex);
  std::copy_n(v, corners, c.begin());
  std::sort(c.begin(), c.end());
  return c;
}

std::vector<Vertex> sorted(std::vector<Vertex> list) {
  std::sort(list.begin(), list.end());
  return list;
}

// Live and frozen ones, each sorted.
std::vector<Corners> cell_set(std::size_t corners, std::span<const Vertex> list, std::span<const Vertex> more = {}) {
  std::vector<Corners> cells;
  for (const auto& part : {list, more}) {
    for (std::size_t c = 0; c < part.size(); c += corners) cells.push_back(sorted(&part[c], corners));
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

struct CellView {
  std::size_t corners;
  std::span<const Vertex> vertices;
  std::span<const std::uint32_t> neighbors;

  std::size_t size() const { return vertices.size() / corners; }
  const Vertex* cell(std::size_t c) const { return &vertices[corners * c]; }
  std::uint32_t across(std::size_t c, std::size_t i) const { return neighbors[corners * c + i]; }
};

// Whether facet i of cell c is facet k of cell d, with the cells on its two sides: d with its vertex k replaced by that
// of c is an odd permutation of c. So infinite cells are oriented as the finite ones they lie beside.
bool common(const CellView& a, std::size_t c, std::size_t i, const CellView& b, std::size_t d, std::size_t k) {
  std::array<std::ptrdiff_t, 4> place{};
  const Vertex *from = a.cell(c), *to = b.cell(d);
  const auto n = static_cast<std::ptrdiff_t>(a.corners);
  bool odd = false;
  for (std::size_t j = 0; j < a.corners; ++j) {
    place[j] = std::find(from, from + n, j == k ? from[i] : to[j]) - from;
    if (place[j] == n) return false;
    for (std::size_t h = 0; h < j; ++h) {
      if (place[h] == place[j]) return false;
      odd ^= place[h] > place[j];
    }
  }
  return odd;
}

bool mutual(const CellView& view, std::size_t c, std::size_t i) {
  const std::size_t d = view.across(c, i);
  if (d >= view.size()) return false;
  for (std::size_t k = 0; k < view.corners; ++k) {
    if (view.across(d, k) == c && common(view, c, i, view, d, k)) return true;
  }
  return false;
}

bool positive(const Kernel& kernel, const Vertex* v) {
  if (kernel.max_dimension() == 2) {
    return independent::orientation_2(kernel.point(v[0]), kernel.point(v[1]), kernel.point(v[2])) > 0;
  }
  return independent::orientation_3(kernel.point(v[0]), kernel.point(v[1]), kernel.point(v[2]), kernel.point(v[3])) > 0;
}

// Orientation, mutual neighbours and common facets; across the border of the hole too. "" if all is well.
std::string wrong_structure(const Kernel& kernel, const CellView& live, const CellView& ice) {
  std::size_t borders = 0, opens = 0;
  for (std::size_t c = 0; c < live.size(); ++c) {
    const Vertex* v = live.cell(c);
    const auto infinite = std::count(v, v + live.corners, infinite_vertex);
    if (infinite > 1) return "two infinite vertices";
    if (infinite == 0 && !positive(kernel, v)) return "a cell is not positive";
    for (std::size_t i = 0; i < live.corners; ++i) {
      const std::uint32_t n = live.across(c, i);
      if (n & across_frozen) {
        const std::size_t f = (n & ~across_frozen) / live.corners, k = (n & ~across_frozen) % live.corners;
        ++borders;
        if (f >= ice.size() || !common(live, c, i, ice, f, k)) return "the border of the hole is not common";
        if (ice.across(f, k) != FinalCells::open) return "a frozen cell does not know its border";
      } else if (!mutual(live, c, i)) {
        return "neighbours are not mutual";
      }
    }
  }
  for (std::size_t c = 0; c < ice.size(); ++c) {
    if (!positive(kernel, ice.cell(c))) return "a frozen cell is not positive";
    for (std::size_t i = 0; i < ice.corners; ++i) {
      if (ice.across(c, i) == FinalCells::open) {
        ++opens;
      } else if (ice.across(c, i) >= ice.size() || !mutual(ice, c, i)) {
        return "frozen neighbours are not mutual";
      }
    }
  }
  return borders == opens ? "" : "the border of the hole has two sides";
}

// A facet that both cells of it do not name becomes one of no cell.
CellList listed(const FinalCells& finals, std::size_t corners) {
  CellList list;
  const CellRecords& rows = finals.rows;
  for (std::uint32_t r = 0; r < rows.size(); ++r) {
    for (std::uint32_t i = 0; i < corners; ++i) {
      const std::uint32_t n = rows[r].neighbors[i];
      const bool open = n == FinalCells::open;
      const bool mutual = !open && n / 4 < rows.size() && rows[n / 4].neighbors[n % 4] == 4 * r + i;
      list.vertices.push_back(rows[r].vertices[i]);
      list.neighbors.push_back(open || mutual ? (open ? n : n / 4) : FinalCells::open - 1);
    }
  }
  return list;
}

std::unique_ptr<Kernel> flat_kernel(bool vectors, int dimension) {
  const FlatOptions options{.vectors = vectors};
  return dimension == 2 ? make_flat_kernel_2(options) : make_flat_kernel_3(options);
}

}  // namespace

KernelPair::KernelPair(bool vectors, int dimension)
    : corners_(static_cast<std::size_t>(dimension) + 1),
      flat_(flat_kernel(vectors, dimension)),
      cgal_(make_kernel(dimension, KernelKind::cgal)) {}

void KernelPair::build(std::span<const Point> points, KeepPoints keep) {
  flat_->build(points, keep);
  cgal_->build(points);
  frozen_ = {};
}

void KernelPair::insert(const Point& p, bool local, InsertMode mode) {
  std::vector<Vertex> around, expected;
  const Insertion got = flat_->insert(p, local, mode, around), made = cgal_->insert(p, local, mode, expected);
  if (got.vertex != made.vertex || got.inserted != made.inserted) fail("insert() answers otherwise");
  if (sorted(around) != sorted(expected)) fail("insert() finds other neighbours");
  if (flat_->dimension() != cgal_->dimension()) fail("another dimension");
}

void KernelPair::remove(Vertex v) {
  if (flat_->alive(v) != cgal_->alive(v)) fail("another vertex is alive");
  if (!flat_->alive(v)) return;
  flat_->remove(v);
  cgal_->remove(v);
  if (flat_->dimension() != cgal_->dimension()) fail("another dimension after a removal");
}

void KernelPair::compare_open(const IsFinal& is_final) {
  if (!full()) return;
  const auto in_order = [&](const Vertex* v) { return is_final(sorted(v, corners_).data()); };
  CellList all;
  std::vector<std::uint8_t> flags;
  const auto open = cell_set(corners_, flat_->explore(in_order, &all, &flags));
  if (open != cell_set(corners_, cgal_->explore(in_order))) fail("explore() finds other cells");
  if (all.vertices != flat_->cells().vertices) return fail("explore() lists other cells than there are");
  std::vector<Vertex> flagged;
  for (std::size_t c = 0; c < flags.size(); ++c) {
    if (flags[c]) flagged.insert(flagged.end(), &all.vertices[corners_ * c], &all.vertices[corners_ * c] + corners_);
  }
  if (open != cell_set(corners_, flagged)) fail("explore() flags other cells than it finds");
}

void KernelPair::freeze(const IsFinal& is_final) {
  if (!full()) return;
  compare_open(is_final);
  const auto in_order = [&](const Vertex* v) { return is_final(sorted(v, corners_).data()); };
  const std::vector<Vertex> open = flat_->explore(in_order);
  const FinalCells finals = flat_->freeze(in_order);
  frozen_ = listed(finals, corners_);
  if (finals.others != open.size() / corners_) fail("freeze() leaves another number of cells than it says");
  if (cell_set(corners_, flat_->cells().vertices) != cell_set(corners_, open)) {
    fail("freeze() leaves other cells than explore() finds");
  }
}

void KernelPair::freeze(const Box& box) {
  freeze([&](const Vertex* v) {
    const auto at = [&](int i) { return flat_->point(v[i]); };
    const Ball ball = corners_ == 3 ? circumcircle(at(0), at(1), at(2)) : circumsphere(at(0), at(1), at(2), at(3));
    return surely_inside(ball, box, flat_->max_dimension());
  });
}

void KernelPair::save_and_load() {
  if (!flat_->load(flat_->save())) fail("does not load what it saved");
}

void KernelPair::exchange() {
  const KernelImage mine = flat_->save(), other = cgal_->save();
  if (!flat_->load(other) || !cgal_->load(mine)) fail("does not load what the other saved");
}

void KernelPair::compare_star(Vertex v) {
  if (!full() || !flat_->alive(v)) return;
  std::vector<Vertex> star, expected;
  flat_->star(v, star);
  cgal_->star(v, expected);
  if (cell_set(corners_, star) != cell_set(corners_, expected)) fail("another star");
  flat_->neighbours(v, star);
  cgal_->neighbours(v, expected);
  if (sorted(star) != sorted(expected)) fail("other neighbours");
}

void KernelPair::compare_edges(Vertex first) {
  if (!full()) return;
  using Edges = std::set<std::pair<Vertex, Vertex>>;
  const auto edges_of = [&](const Kernel& kernel) {
    Edges edges;
    kernel.edges_from(first, [&](Vertex v, Vertex w) {
      if (v < first || w == infinite_vertex) fail("an edge that was not asked for");
      edges.emplace(std::max(v, w), std::min(v, w));
    });
    return edges;
  };
  if (edges_of(*flat_) != edges_of(*cgal_)) fail("other edges");
}

void KernelPair::compare_cells() {
  if (flat_->dimension() != cgal_->dimension()) return fail("another dimension");
  if (flat_->vertices() != cgal_->vertices()) return fail("other vertices");
  for (Vertex v = 1; v <= flat_->vertices(); ++v) {
    if (flat_->alive(v) != cgal_->alive(v)) return fail("another vertex is alive");
    if (!flat_->alive(v)) continue;
    if (flat_->is_local(v) != cgal_->is_local(v)) return fail("another vertex is local");
    if (flat_->point(v) != cgal_->point(v)) return fail("another point");
  }
  if (!full()) return;
  const CellList list = flat_->cells();
  if (cell_set(corners_, list.vertices, frozen_.vertices) != cell_set(corners_, cgal_->cells().vertices)) {
    fail("other cells");
  }
  const CellView live{corners_, list.vertices, list.neighbors}, ice{corners_, frozen_.vertices, frozen_.neighbors};
  if (const std::string what = wrong_structure(*flat_, live, ice); !what.empty()) fail(what);
}

}  // namespace tessera::testing

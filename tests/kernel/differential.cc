#include "tests/kernel/differential.h"

#include <algorithm>
#include <span>

#include "src/kernel/flat_kernel_3.h"
#include "src/tile/circumsphere.h"

namespace tessera::testing {
namespace {

using Corners = std::array<Vertex, 4>;

Corners sorted(const Vertex* v) {
  Corners c{v[0], v[1], v[2], v[3]};
  std::sort(c.begin(), c.end());
  return c;
}

// Live and frozen ones, each sorted.
std::vector<Corners> cell_set(std::span<const Vertex> corners, std::span<const Vertex> more = {}) {
  std::vector<Corners> cells;
  for (std::size_t c = 0; c < corners.size(); c += 4) cells.push_back(sorted(&corners[c]));
  for (std::size_t c = 0; c < more.size(); c += 4) cells.push_back(sorted(&more[c]));
  std::sort(cells.begin(), cells.end());
  return cells;
}

// Orientation, mutual neighbours and common facets; across the border of the hole too. "" if all is well.
std::string wrong_structure(const Kernel& kernel, const CellList& list, const FrozenCells& frozen) {
  struct View {
    std::span<const Vertex> v;
    std::span<const std::uint32_t> n;
  };
  const View live{list.vertices, list.neighbors}, ice{frozen.vertices, frozen.neighbors};
  std::size_t borders = 0, opens = 0;
  const auto common = [](const View& a, std::size_t c, std::size_t i, const View& b, std::size_t d, std::size_t k) {
    Corners f{}, g{};
    for (std::size_t j = 0; j < 4; ++j) f[j] = j == i ? ~0u : a.v[4 * c + j], g[j] = j == k ? ~0u : b.v[4 * d + j];
    std::sort(f.begin(), f.end());
    std::sort(g.begin(), g.end());
    return f == g;
  };
  const auto mutual = [&](const View& view, std::size_t c, std::size_t i, std::size_t d) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (view.n[4 * d + k] == c && common(view, c, i, view, d, k)) return true;
    }
    return false;
  };
  const auto positive = [&](const Vertex* v) {
    return orientation_3(kernel.point(v[0]), kernel.point(v[1]), kernel.point(v[2]), kernel.point(v[3])) > 0;
  };
  for (std::size_t c = 0; c < live.v.size() / 4; ++c) {
    const Vertex* v = &live.v[4 * c];
    if (std::count(v, v + 4, infinite_vertex) > 1) return "two infinite vertices";
    if (std::count(v, v + 4, infinite_vertex) == 0 && !positive(v)) return "a cell is not positive";
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t n = live.n[4 * c + i];
      if (n & across_frozen) {
        const std::size_t f = (n & ~across_frozen) / 4, k = n & 3;
        ++borders;
        if (f >= ice.v.size() / 4 || !common(live, c, i, ice, f, k)) return "the border of the hole is not common";
        if (ice.n[4 * f + k] != FrozenCells::open) return "a frozen cell does not know its border";
      } else if (n >= live.v.size() / 4 || !mutual(live, c, i, n)) {
        return "neighbours are not mutual";
      }
    }
  }
  for (std::size_t c = 0; c < ice.v.size() / 4; ++c) {
    if (!positive(&ice.v[4 * c])) return "a frozen cell is not positive";
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t n = ice.n[4 * c + i];
      if (n == FrozenCells::open) {
        ++opens;
      } else if (n >= ice.v.size() / 4 || !mutual(ice, c, i, n)) {
        return "frozen neighbours are not mutual";
      }
    }
  }
  return borders == opens ? "" : "the border of the hole has two sides";
}

}  // namespace

KernelPair::KernelPair(bool vectors)
    : flat_(vectors ? make_kernel(3, KernelKind::flat) : make_plain_flat_kernel_3()),
      cgal_(make_kernel(3, KernelKind::cgal)) {}

void KernelPair::build(std::span<const Point> points, KeepPoints keep) {
  flat_->build(points, keep);
  cgal_->build(points);
  frozen_ = {};
}

void KernelPair::insert(const Point& p, bool local, InsertMode mode) {
  std::vector<Vertex> around, expected;
  const Insertion got = flat_->insert(p, local, mode, around), made = cgal_->insert(p, local, mode, expected);
  std::sort(around.begin(), around.end());
  std::sort(expected.begin(), expected.end());
  if (got.vertex != made.vertex || got.inserted != made.inserted) fail("insert() answers otherwise");
  if (around != expected) fail("insert() finds other neighbours");
  if (flat_->dimension() != cgal_->dimension()) fail("another dimension");
}

void KernelPair::remove(Vertex v) {
  if (flat_->alive(v) != cgal_->alive(v)) fail("another vertex is alive");
  if (!flat_->alive(v)) return;
  flat_->remove(v);
  cgal_->remove(v);
  if (flat_->dimension() != cgal_->dimension()) fail("another dimension after a removal");
}

void KernelPair::freeze(const Box& box) {
  if (flat_->dimension() < 3) return;
  // The bound of a circumsphere depends on the order of the corners, which differs between kernels.
  const auto settled = [&](const Vertex* v) {
    const Corners c = sorted(v);
    return surely_inside(circumsphere(flat_->point(c[0]), flat_->point(c[1]), flat_->point(c[2]), flat_->point(c[3])),
                         box, 3);
  };
  const std::vector<Vertex> open = flat_->explore(settled), expected = cgal_->explore(settled);
  if (cell_set(open) != cell_set(expected)) fail("explore() finds other cells");
  frozen_ = flat_->freeze(settled);
  if (cell_set(flat_->cells().vertices) != cell_set(open)) fail("freeze() leaves other cells than explore() finds");
}

void KernelPair::save_and_load() {
  if (!flat_->load(flat_->save())) fail("does not load what it saved");
}

void KernelPair::compare_star(Vertex v) {
  if (flat_->dimension() < 3 || !flat_->alive(v)) return;
  std::vector<Vertex> star, expected;
  flat_->star(v, star);
  cgal_->star(v, expected);
  if (cell_set(star) != cell_set(expected)) fail("another star");
  flat_->neighbours(v, star);
  cgal_->neighbours(v, expected);
  std::sort(star.begin(), star.end());
  std::sort(expected.begin(), expected.end());
  if (star != expected) fail("other neighbours");
}

void KernelPair::compare_cells() {
  if (flat_->dimension() != cgal_->dimension()) return fail("another dimension");
  if (flat_->dimension() < 3) return;
  const CellList list = flat_->cells();
  if (cell_set(list.vertices, frozen_.vertices) != cell_set(cgal_->cells().vertices)) fail("other cells");
  if (const std::string what = wrong_structure(*flat_, list, frozen_); !what.empty()) fail(what);
}

}  // namespace tessera::testing

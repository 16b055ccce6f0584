// The flat kernel against CGAL's on random small sets of lattice points: every degeneracy occurs.
//   lattice_cases [CASES] [FIRST_SEED]
// Each seed is one case: a lattice of 2^3 to 6^3, 5 to 40 points (more where cells are frozen), and a way to use the
// kernel: built, built and inserted into with labels, with removals, frozen; now and then saved and loaded. After every
// step the answers are compared, at the end the cells, infinite ones included, and the structure. Stops at the first
// difference, whose seed is told.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "src/kernel/flat_kernel_3.h"
#include "src/kernel/kernel.h"
#include "src/tile/circumsphere.h"

namespace tessera::testing {
namespace {

using Rng = std::mt19937_64;
using Corners = std::array<Vertex, 4>;

std::size_t below(Rng& rng, std::size_t n) { return rng() % n; }

Corners sorted(const Vertex* v) {
  Corners c{v[0], v[1], v[2], v[3]};
  std::sort(c.begin(), c.end());
  return c;
}

// Live and frozen ones, each sorted.
std::vector<Corners> cell_set(const CellList& list, const FrozenCells& frozen = {}) {
  std::vector<Corners> cells;
  for (std::size_t c = 0; c < list.vertices.size(); c += 4) cells.push_back(sorted(&list.vertices[c]));
  for (std::size_t c = 0; c < frozen.vertices.size(); c += 4) cells.push_back(sorted(&frozen.vertices[c]));
  std::sort(cells.begin(), cells.end());
  return cells;
}

// Orientation, mutual neighbours and common facets; across the border of the hole too. "" if all is well.
std::string wrong_structure(const Kernel& kernel, const CellList& list, const FrozenCells& frozen) {
  struct View {
    const std::vector<Vertex>& v;
    const std::vector<std::uint32_t>& n;
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

class Case {
 public:
  explicit Case(std::uint64_t seed)
      : rng_(seed),
        flat_(seed % 8 < 6 ? make_kernel(3, KernelKind::flat) : make_plain_flat_kernel_3()),
        cgal_(make_kernel(3, KernelKind::cgal)) {
    const bool freeze = seed % 4 == 3;
    k_ = freeze ? 3 + below(rng_, 4) : 2 + below(rng_, 5);
    draw_points(freeze ? 20 + below(rng_, 120) : 5 + below(rng_, 36));
    if (seed % 4 == 0) {
      build(points_.size());
    } else if (seed % 4 == 1) {
      build(below(rng_, points_.size() + 1));
      insert_rest();
    } else if (seed % 4 == 2) {
      build(below(rng_, points_.size() + 1));
      remove_and_insert();
    } else {
      freeze_and_insert();
    }
    compare_cells();
  }
  const std::string& wrong() const { return wrong_; }

 private:
  void fail(const std::string& what) {
    if (wrong_.empty()) wrong_ = what;
  }

  // Distinct points of the lattice; in some cases scaled so that coordinates are not exact, in some all or the first
  // ones flat.
  void draw_points(std::size_t n) {
    std::vector<Point> all;
    const bool flat = below(rng_, 16) == 0;
    const std::size_t kind = below(rng_, 4);
    const double scale = kind == 0 ? 0.01 : kind == 1 ? 0x1p-500 : 1, shift = kind == 0 ? 650000 : 0;
    step_ = scale, origin_ = shift;
    for (std::size_t x = 0; x < k_; ++x) {
      for (std::size_t y = 0; y < k_; ++y) {
        for (std::size_t z = 0; z < (flat ? 1 : k_); ++z) {
          const auto at = [&](std::size_t i) { return static_cast<double>(i) * scale + shift; };
          all.push_back({at(x), at(y), at(z)});
        }
      }
    }
    std::shuffle(all.begin(), all.end(), rng_);
    if (all.size() > n) all.resize(n);
    if (below(rng_, 4) == 0) std::sort(all.begin(), all.end());
    points_ = std::move(all);
  }

  void build(std::size_t n) {
    const std::span<const Point> first(points_.data(), n);
    flat_->build(first, below(rng_, 2) == 0 ? KeepPoints::copied : KeepPoints::borrowed);
    cgal_->build(first);
    next_ = n;
  }

  void insert(const Point& p, bool local, InsertMode mode) {
    std::vector<Vertex> around, expected;
    const Insertion got = flat_->insert(p, local, mode, around), made = cgal_->insert(p, local, mode, expected);
    std::sort(around.begin(), around.end());
    std::sort(expected.begin(), expected.end());
    if (got.vertex != made.vertex || got.inserted != made.inserted) fail("insert() answers otherwise");
    if (around != expected) fail("insert() finds other neighbours");
    if (flat_->dimension() != cgal_->dimension()) fail("another dimension");
  }

  void insert_any() {
    const Point& p = below(rng_, 8) == 0 ? points_[below(rng_, points_.size())] : points_[next_++];
    insert(p, below(rng_, 2) == 0, below(rng_, 2) == 0 ? InsertMode::always : InsertMode::if_local_neighbour);
  }

  void insert_rest() {
    while (next_ < points_.size() && wrong_.empty()) {
      insert_any();
      if (below(rng_, 16) == 0) reload();
      if (below(rng_, 8) == 0) compare_star();
    }
  }

  void remove_and_insert() {
    for (int step = 0; step < 40 && wrong_.empty(); ++step) {
      if (below(rng_, 2) == 0 && next_ < points_.size()) {
        insert_any();
        continue;
      }
      if (flat_->vertices() == 0) continue;
      const Vertex v = static_cast<Vertex>(1 + below(rng_, flat_->vertices()));
      if (flat_->alive(v) != cgal_->alive(v)) fail("another vertex is alive");
      if (!flat_->alive(v)) continue;
      flat_->remove(v);
      cgal_->remove(v);
      if (flat_->dimension() != cgal_->dimension()) fail("another dimension after a removal");
      if (below(rng_, 8) == 0) reload();
      if (below(rng_, 4) == 0) compare_cells();
    }
  }

  // The points of a part of the lattice are local, and cells inside that part are frozen: no other point is in it.
  void freeze_and_insert() {
    const double cut = (static_cast<double>(k_ / 2 + below(rng_, k_ - k_ / 2)) - 0.5) * step_ + origin_;
    Box box;
    box.hi.x = cut;
    if (below(rng_, 2) == 0) box.hi.y = cut;
    std::vector<Point> locals, others;
    for (const Point& p : points_) (box.contains(p) ? locals : others).push_back(p);
    points_ = locals;
    build(locals.size());
    const std::size_t seeds = below(rng_, 5);
    for (std::size_t i = 0; i < others.size() && i < seeds; ++i) insert(others[i], false, InsertMode::always);
    if (flat_->dimension() == 3) {
      const auto settled = [&](const Vertex* c) {
        const Ball ball = circumsphere(flat_->point(c[0]), flat_->point(c[1]), flat_->point(c[2]), flat_->point(c[3]));
        return surely_inside(ball, box, 3);
      };
      std::vector<Vertex> open = flat_->explore(settled), expected = cgal_->explore(settled);
      if (cell_set({open, {}}) != cell_set({expected, {}})) fail("explore() finds other cells");
      frozen_ = flat_->freeze(settled);
      if (cell_set(flat_->cells()) != cell_set({open, {}})) fail("freeze() leaves other cells than explore() finds");
    }
    for (std::size_t i = std::min(seeds, others.size()); i < others.size() && wrong_.empty(); ++i) {
      insert(others[i], false, below(rng_, 4) == 0 ? InsertMode::always : InsertMode::if_local_neighbour);
      if (below(rng_, 16) == 0) reload();
      if (below(rng_, 16) == 0) insert(others[below(rng_, i + 1)], false, InsertMode::if_local_neighbour);
    }
  }

  void reload() {
    const KernelImage image = flat_->save();
    if (!flat_->load(image)) fail("does not load what it saved");
  }

  void compare_star() {
    if (flat_->dimension() < 3) return;
    const Vertex v = static_cast<Vertex>(1 + below(rng_, flat_->vertices()));
    std::vector<Vertex> star, expected;
    flat_->star(v, star);
    cgal_->star(v, expected);
    if (cell_set({star, {}}) != cell_set({expected, {}})) fail("another star");
    flat_->neighbours(v, star);
    cgal_->neighbours(v, expected);
    std::sort(star.begin(), star.end());
    std::sort(expected.begin(), expected.end());
    if (star != expected) fail("other neighbours");
  }

  void compare_cells() {
    if (flat_->dimension() != cgal_->dimension()) return fail("another dimension");
    if (flat_->dimension() < 3) return;
    const CellList list = flat_->cells();
    if (cell_set(list, frozen_) != cell_set(cgal_->cells())) return fail("other cells");
    if (const std::string what = wrong_structure(*flat_, list, frozen_); !what.empty()) fail(what);
  }

  Rng rng_;
  std::unique_ptr<Kernel> flat_, cgal_;
  std::size_t k_ = 2, next_ = 0;
  double step_ = 1, origin_ = 0;
  std::vector<Point> points_;
  FrozenCells frozen_;
  std::string wrong_;
};

}  // namespace
}  // namespace tessera::testing

int main(int argc, char** argv) {
  const std::uint64_t cases = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1000;
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  for (std::uint64_t seed = first; seed < first + cases; ++seed) {
    const tessera::testing::Case one(seed);
    if (one.wrong().empty()) continue;
    std::printf("seed %llu: %s\n", static_cast<unsigned long long>(seed), one.wrong().c_str());
    return 1;
  }
  std::printf("%llu cases from seed %llu: equal\n", static_cast<unsigned long long>(cases),
              static_cast<unsigned long long>(first));
  return 0;
}

// The flat kernel against CGAL's on random small sets of lattice points: every degeneracy occurs.
//   lattice_cases [CASES] [FIRST_SEED] [DIMENSION]
// Each seed is one case: a lattice of 2^3 to 6^3, in 2D of 2^2 to 12^2, 5 to 40 points (more where cells are frozen),
// and a way to use the kernel: built, built and inserted into with labels, with removals, frozen; now and then saved
// and loaded. After every step the answers are compared, at the end the cells, infinite ones included, and the
// structure. Stops at the first difference, whose seed is told.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "tests/kernel/differential.h"

namespace tessera::testing {
namespace {

class Case {
 public:
  Case(std::uint64_t seed, int dimension) : rng_(seed), dimension_(dimension), pair_(seed % 8 < 6, dimension) {
    const bool freeze = seed % 4 == 3;
    k_ = freeze ? 3 + below(4) : 2 + below(5);
    if (dimension == 2) k_ += below(k_ + 1);
    draw_points(freeze ? 20 + below(120) : 5 + below(36));
    if (seed % 4 == 0) {
      build(points_.size());
    } else if (seed % 4 == 1) {
      build(below(points_.size() + 1));
      insert_rest();
    } else if (seed % 4 == 2) {
      build(below(points_.size() + 1));
      remove_and_insert();
    } else {
      freeze_and_insert();
    }
    pair_.compare_cells();
  }
  const std::string& wrong() const { return pair_.wrong(); }
  std::size_t frozen_cells() const { return pair_.frozen_cells(); }

 private:
  std::size_t below(std::size_t n) { return rng_() % n; }

  // Distinct points of the lattice; in some cases scaled so that coordinates or differences are not exact, in some all
  // in one plane, in some in lexicographic order.
  void draw_points(std::size_t n) {
    std::vector<Point> all;
    const bool flat = below(16) == 0;  // in 2D on one line
    const std::size_t kind = below(4);
    step_ = kind == 0 ? 0.01 : kind == 1 ? 0x1p-500 : 1;
    origin_ = kind == 0 ? 650000 : 0;
    const auto at = [&](std::size_t i) { return static_cast<double>(i) * step_ + origin_; };
    for (std::size_t x = 0; x < k_; ++x) {
      for (std::size_t y = 0; y < (dimension_ == 2 && flat ? 1 : k_); ++y) {
        if (dimension_ == 2) all.push_back({at(x), at(y), 0});
        for (std::size_t z = 0; dimension_ == 3 && z < (flat ? 1 : k_); ++z) all.push_back({at(x), at(y), at(z)});
      }
    }
    std::shuffle(all.begin(), all.end(), rng_);
    if (all.size() > n) all.resize(n);
    if (below(4) == 0) std::sort(all.begin(), all.end());
    points_ = std::move(all);
  }

  void build(std::size_t n) {
    pair_.build({points_.data(), n}, below(2) == 0 ? KeepPoints::copied : KeepPoints::borrowed);
    next_ = n;
  }

  void insert_any() {
    const Point& p = below(8) == 0 ? points_[below(points_.size())] : points_[next_++];
    pair_.insert(p, below(2) == 0, below(2) == 0 ? InsertMode::always : InsertMode::if_local_neighbour);
  }

  Vertex any_vertex() { return static_cast<Vertex>(1 + below(pair_.flat().vertices())); }

  void insert_rest() {
    while (next_ < points_.size() && wrong().empty()) {
      insert_any();
      if (below(4) == 0) pair_.compare_star(pair_.flat().vertices());
      if (below(16) == 0) pair_.save_and_load();
      if (below(8) == 0) pair_.compare_star(any_vertex());
      if (below(16) == 0) pair_.compare_edges(any_vertex());
    }
  }

  void remove_and_insert() {
    for (int step = 0; step < 40 && wrong().empty(); ++step) {
      if (below(2) == 0 && next_ < points_.size()) {
        insert_any();
      } else if (pair_.flat().vertices() > 0) {
        pair_.remove(any_vertex());
      }
      if (below(16) == 0) pair_.save_and_load();
      if (below(8) == 0) pair_.compare_cells();
    }
  }

  // The points in a part of the lattice are local, and cells inside that part are frozen: no other point is in it.
  void freeze_and_insert() {
    Box box;
    box.hi.x = (static_cast<double>(k_ / 2 + below(k_ - k_ / 2)) - 0.5) * step_ + origin_;
    if (below(2) == 0) box.hi.y = box.hi.x;
    std::vector<Point> locals, others;
    for (const Point& p : points_) (box.contains(p) ? locals : others).push_back(p);
    points_ = locals;
    build(locals.size());
    const std::size_t seeds = std::min(others.size(), below(5));
    for (std::size_t i = 0; i < seeds; ++i) pair_.insert(others[i], false, InsertMode::always);
    pair_.freeze(box);
    for (std::size_t i = seeds; i < others.size() && wrong().empty(); ++i) {
      pair_.insert(others[i], false, below(4) == 0 ? InsertMode::always : InsertMode::if_local_neighbour);
      if (below(16) == 0) pair_.save_and_load();
      if (below(16) == 0) pair_.insert(others[below(i + 1)], false, InsertMode::if_local_neighbour);
      if (below(16) == 0) pair_.compare_edges(static_cast<Vertex>(locals.size() + 1 + below(i + 1)));
    }
  }

  std::mt19937_64 rng_;
  int dimension_;
  KernelPair pair_;
  std::size_t k_ = 2, next_ = 0;
  double step_ = 1, origin_ = 0;
  std::vector<Point> points_;
};

}  // namespace
}  // namespace tessera::testing

int main(int argc, char** argv) {
  const unsigned long long cases = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1000;
  const unsigned long long first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  const int dimension = argc > 3 && std::atoi(argv[3]) == 2 ? 2 : 3;
  unsigned long long frozen = 0;
  for (auto seed = first; seed < first + cases; ++seed) {
    const tessera::testing::Case one(seed, dimension);
    frozen += one.frozen_cells();
    if (one.wrong().empty()) continue;
    std::printf("seed %llu: %s\n", seed, one.wrong().c_str());
    return 1;
  }
  std::printf("%llu cases in %dD from seed %llu, %llu cells frozen: equal\n", cases, dimension, first, frozen);
  return 0;
}

// The flat kernel in 2D against the CGAL kernel: equal answers to equal calls.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "tests/kernel/kernel_testing.h"

namespace tessera::testing {
namespace {

using Rng = std::mt19937_64;

std::size_t below(Rng& rng, std::size_t n) { return rng() % n; }

template <class T>
std::vector<T> sorted(std::vector<T> list) {
  std::sort(list.begin(), list.end());
  return list;
}

// 4 to 40 distinct points of a lattice of 2 x 2 to 8 x 8, sometimes of steps that doubles do not hold.
std::vector<Point> lattice_case(Rng& rng) {
  const std::size_t nx = 2 + below(rng, 7), ny = 2 + below(rng, 7);
  const std::size_t n = std::min(4 + below(rng, 37), nx * ny);
  const double step = below(rng, 2) ? 1 : 0.01, origin = below(rng, 2) ? 0 : 6.8e6;
  std::vector<std::size_t> order = shuffled(nx * ny, rng());
  std::vector<Point> points;
  for (std::size_t i = 0; i < n; ++i) {
    points.push_back(
        {origin + static_cast<double>(order[i] % nx) * step, static_cast<double>(order[i] / nx) * step, 0});
  }
  return points;
}

struct Pair {
  std::unique_ptr<Kernel> flat = make_kernel(2, KernelKind::flat), cgal = make_kernel(2, KernelKind::cgal);

  void expect_equal() const {
    ASSERT_EQ(flat->dimension(), cgal->dimension());
    ASSERT_EQ(flat->vertices(), cgal->vertices());
    if (flat->dimension() < 2) return;
    ASSERT_EQ(difference(cells_of(*cgal), cells_of(*flat)), "");
    ASSERT_EQ(wrong_with(*flat), "");
  }
  void build(const std::vector<Point>& points) const {
    flat->build(points);
    cgal->build(points);
  }
  void insert(const Point& p, bool local, InsertMode mode) const {
    std::vector<Vertex> around, expected;
    const Insertion made = flat->insert(p, local, mode, around), reference = cgal->insert(p, local, mode, expected);
    ASSERT_EQ(made.vertex, reference.vertex);
    ASSERT_EQ(made.inserted, reference.inserted);
    ASSERT_EQ(sorted(around), sorted(expected));
  }
  void remove(Vertex v) const {
    flat->remove(v);
    cgal->remove(v);
  }
};

TEST(FlatKernel2, BuildsWhatCgalBuildsOnLattices) {
  Rng rng(1);
  for (int round = 0; round < 30000 && !HasFatalFailure(); ++round) {
    const Pair pair;
    pair.build(lattice_case(rng));
    pair.expect_equal();
  }
}

TEST(FlatKernel2, InsertsAsCgalOnLattices) {
  Rng rng(2);
  for (int round = 0; round < 10000 && !HasFatalFailure(); ++round) {
    const auto points = lattice_case(rng);
    const std::size_t first = below(rng, points.size() + 1);
    const Pair pair;
    pair.build({points.begin(), points.begin() + static_cast<std::ptrdiff_t>(first)});
    for (std::size_t i = first; i < points.size() && !HasFatalFailure(); ++i) {
      const auto mode = below(rng, 2) ? InsertMode::always : InsertMode::if_local_neighbour;
      pair.insert(points[below(rng, 5) == 0 ? below(rng, points.size()) : i], below(rng, 3) == 0, mode);
    }
    pair.expect_equal();
  }
}

TEST(FlatKernel2, RemovesAsCgalOnLattices) {
  Rng rng(3);
  for (int round = 0; round < 10000 && !HasFatalFailure(); ++round) {
    const auto points = lattice_case(rng);
    const Pair pair;
    pair.build(points);
    std::size_t left = points.size();
    for (const std::size_t i : shuffled(points.size(), rng())) {
      if (left-- <= 1 || HasFatalFailure()) break;
      pair.remove(static_cast<Vertex>(i + 1));
      if (below(rng, 4) == 0) pair.insert(points[i], true, InsertMode::always), ++left;
      if (below(rng, 4) == 0) pair.expect_equal();
    }
  }
}

TEST(FlatKernel2, StarsNeighboursAndExplorationAreCgals) {
  Rng rng(4);
  for (int round = 0; round < 3000 && !HasFatalFailure(); ++round) {
    const auto points = lattice_case(rng);
    const Pair pair;
    pair.build({points.begin(), points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2)});
    for (std::size_t i = points.size() / 2; i < points.size(); ++i) {
      pair.insert(points[i], below(rng, 4) != 0, InsertMode::always);
    }
    if (pair.flat->dimension() < 2) continue;
    const auto triangles = [](const std::vector<Vertex>& list) {
      std::vector<std::vector<Vertex>> cells;
      for (std::size_t c = 0; c < list.size(); c += 3) {
        cells.push_back(sorted<Vertex>({list[c], list[c + 1], list[c + 2]}));
      }
      return sorted(cells);
    };
    std::vector<Vertex> mine, theirs;
    for (Vertex v = 1; v <= pair.flat->vertices(); ++v) {
      pair.flat->neighbours(v, mine);
      pair.cgal->neighbours(v, theirs);
      ASSERT_EQ(sorted(mine), sorted(theirs));
      pair.flat->star(v, mine);
      pair.cgal->star(v, theirs);
      ASSERT_EQ(triangles(mine), triangles(theirs));
    }
    const auto is_final = [](const Vertex* v) { return (v[0] + v[1] + v[2]) % 3 != 0; };
    CellList all;
    std::vector<std::uint8_t> open;
    ASSERT_EQ(triangles(pair.flat->explore(is_final, &all, &open)), triangles(pair.cgal->explore(is_final)));
    std::vector<Vertex> flagged;
    for (std::size_t c = 0; c < open.size(); ++c) {
      if (open[c]) flagged.insert(flagged.end(), &all.vertices[3 * c], &all.vertices[3 * c] + 3);
    }
    ASSERT_EQ(triangles(flagged), triangles(pair.flat->explore(is_final)));
  }
}

TEST(FlatKernel2, LoadsWhatEitherKernelSaved) {
  Rng rng(5);
  for (int round = 0; round < 3000 && !HasFatalFailure(); ++round) {
    const auto points = lattice_case(rng);
    const Pair pair;
    pair.build({points.begin(), points.end() - 2});
    const Pair copies;
    ASSERT_TRUE(copies.flat->load(pair.cgal->save()));
    ASSERT_TRUE(copies.cgal->load(pair.flat->save()));
    copies.expect_equal();
    for (std::size_t i = points.size() - 2; i < points.size(); ++i) {
      copies.insert(points[i], true, InsertMode::always);
    }
    copies.expect_equal();
  }
}

TEST(FlatKernel2, IsCgalsOnAllCloudsOfTheKernelTests) {
  for (const auto* clouds : {&spanning_clouds(), &flat_clouds()}) {
    for (const KernelCloud& cloud : *clouds) {
      if (cloud.dimension != 2) continue;
      const Pair built, inserted;
      built.build(cloud.points);
      built.expect_equal();
      for (const Point& p : cloud.points) inserted.insert(p, true, InsertMode::always);
      inserted.expect_equal();
      for (Vertex v = 1; v < cloud.points.size(); v += 2) built.remove(v);
      built.expect_equal();
    }
  }
}

// Nearly cocircular and nearly collinear points, at scales where the filter fails and differences are rounded.
TEST(FlatKernel2, IsCgalsOnCirclesLinesAndGridsThatAreRounded) {
  Rng rng(6);
  const auto unit = [&] { return std::uniform_real_distribution<>(0, 1)(rng); };
  for (const double scale : {1.0, 1e-160, 1e100}) {
    for (int kind = 0; kind < 4; ++kind) {
      std::vector<Point> points;
      for (int i = 0; i < 1000; ++i) {
        const double t = 6.283185307179586 * unit(), s = unit();
        const Point p = kind == 0   ? Point{std::cos(t), std::sin(t), 0}
                        : kind == 1 ? Point{s, 0.3 * s + 0.7, 0}
                        : kind == 2 ? Point{0.1 * static_cast<double>(i % 31), 0.1 * static_cast<double>(i / 31), 0}
                                    : Point{std::exp(40 * s), std::exp(40 * unit()), 0};
        points.push_back({p.x * scale, p.y * scale, 0});
      }
      std::sort(points.begin(), points.end());
      points.erase(std::unique(points.begin(), points.end()), points.end());
      std::shuffle(points.begin(), points.end(), rng);
      const Pair pair;
      pair.build(points);
      pair.expect_equal();
    }
  }
}

// Local points in a box; triangles whose circle lies inside it are frozen; what comes later lies outside.
TEST(FlatKernel2, FrozenTrianglesAndTheRestAreTheTriangulation) {
  Rng rng(7);
  for (int round = 0; round < 2000 && !HasFatalFailure(); ++round) {
    const bool lattice = round % 2 == 0;
    const std::size_t side = 12, n = 20 + below(rng, 100);
    std::vector<Point> inside, outside;
    for (const std::size_t i : shuffled(side * side, rng())) {
      if (inside.size() + outside.size() == n) break;
      Point p{static_cast<double>(i % side), static_cast<double>(i / side), 0};
      if (!lattice)
        p.x += 0.01 * static_cast<double>(below(rng, 50)), p.y += 0.01 * static_cast<double>(below(rng, 50));
      const bool is_inside = p.x >= 3 && p.x < 10 && p.y >= 1 && p.y < 9;
      (is_inside ? inside : outside).push_back(p);
    }
    const auto kernel = make_kernel(2, KernelKind::flat);
    kernel->build(inside);
    if (kernel->dimension() < 2) continue;
    const auto is_final = [&](const Vertex* v) {
      const Point a = kernel->point(v[0]), b = kernel->point(v[1]), c = kernel->point(v[2]);
      const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y, area = 2 * (bx * cy - by * cx);
      const double ux = (cy * (bx * bx + by * by) - by * (cx * cx + cy * cy)) / area;
      const double uy = (bx * (cx * cx + cy * cy) - cx * (bx * bx + by * by)) / area;
      const double r = std::hypot(ux, uy) + 1e-6, x = a.x + ux, y = a.y + uy;
      return x - r > 3 && x + r < 10 && y - r > 1 && y + r < 9;
    };
    const FinalCells finals = kernel->freeze(is_final);
    const CellRecords& frozen = finals.rows;
    std::ptrdiff_t open = 0;
    for (std::uint32_t f = 0; f < 3 * frozen.size(); ++f) {
      const std::uint32_t next = frozen[f / 3].neighbors[f % 3];
      open += next == FinalCells::open;
      if (next == FinalCells::open) continue;
      ASSERT_LT(next, 4 * frozen.size());
      ASSERT_EQ(frozen[next / 4].neighbors[next % 4], 4 * (f / 3) + f % 3);
    }
    std::vector<Vertex> around;
    std::vector<PointId> ids;
    for (std::uint64_t i = 0; i < inside.size(); ++i) ids.push_back({i});
    std::vector<Point> all = inside;
    for (const Point& p : outside) {
      const bool copied = below(rng, 20) == 0;
      if (copied) {
        ASSERT_TRUE(kernel->load(kernel->save()));
      }
      ASSERT_TRUE(kernel->insert(p, false, InsertMode::always, around).inserted);
      ids.push_back({ids.size()});
      all.push_back(p);
    }
    const CellList rest = kernel->cells();
    std::vector<IdCell> cells = cells_of(*kernel, ids);
    for (std::size_t f = 0; f < frozen.size(); ++f) {
      const Vertex* v = frozen[f].vertices;
      IdCell cell{{{v[0] - 1}, {v[1] - 1}, {v[2] - 1}, infinite_id}};
      std::sort(cell.begin(), cell.end());
      cells.push_back(cell);
    }
    std::sort(cells.begin(), cells.end());
    ASSERT_EQ(difference(reference(all, 2), cells), "");
    // Across the edges of the hole lie the frozen triangles that have them in common.
    std::size_t across = 0;
    for (std::size_t c = 0; c < rest.neighbors.size(); ++c) {
      const std::uint32_t to = rest.neighbors[c];
      if (!(to & across_frozen)) continue;
      ++across;
      const std::uint32_t f = (to & ~across_frozen) / 3, k = (to & ~across_frozen) % 3;
      ASSERT_EQ(frozen[f].neighbors[k], FinalCells::open);
      ASSERT_EQ(frozen[f].vertices[(k + 1) % 3], rest.vertices[c / 3 * 3 + (c % 3 + 2) % 3]);
      ASSERT_EQ(frozen[f].vertices[(k + 2) % 3], rest.vertices[c / 3 * 3 + (c % 3 + 1) % 3]);
    }
    ASSERT_EQ(static_cast<std::ptrdiff_t>(across), open);
  }
}

TEST(FlatKernel2, BorrowedPointsAreReadInPlaceAndCopiedBeforeOneIsAdded) {
  Rng rng(8);
  const auto points = lattice_case(rng);
  const Pair pair;
  pair.flat->build(points, KeepPoints::borrowed);
  pair.cgal->build(points);
  pair.expect_equal();
  pair.insert({1e7, 3.5, 0}, true, InsertMode::always);
  pair.insert(points[0], true, InsertMode::always);
  pair.expect_equal();
}

}  // namespace
}  // namespace tessera::testing

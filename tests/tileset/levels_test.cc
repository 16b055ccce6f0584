// Pieces of closed surfaces that are made coarser again and again: the border of each stays as it is. And how far they
// are off then.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "src/result/tileset/surface.h"

namespace tessera::tileset {
namespace {

using Chain = std::map<std::pair<std::uint64_t, std::uint64_t>, int>;

// How much more often an edge is passed one way than the other, by ids, where that is not 0.
Chain border_of(const Surface& surface) {
  Chain sums;
  for (std::size_t i = 0; i < surface.corners.size(); ++i) {
    const auto id = [&](std::size_t corner) { return surface.vertices[surface.corners[corner]].id.value; };
    const std::uint64_t from = id(i), to = id(i % 3 == 2 ? i - 2 : i + 1);
    sums[std::minmax(from, to)] += from < to ? 1 : -1;
  }
  std::erase_if(sums, [](const auto& edge) { return edge.second == 0; });
  return sums;
}

// The boundary of random cubes, which touches itself along edges and at vertices.
class Cubes {
 public:
  Cubes(std::mt19937& dice, double side, bool far) : side_(side) {
    std::bernoulli_distribution filled(0.5);
    bool full[edge + 2][edge + 2][edge + 2] = {};
    for (int x = 1; x <= edge; ++x)
      for (int y = 1; y <= edge; ++y)
        for (int z = 1; z <= edge; ++z) full[x][y][z] = filled(dice);
    for (int x = 0; x <= edge; ++x)
      for (int y = 0; y <= edge; ++y)
        for (int z = 0; z <= edge; ++z)
          for (int axis = 0; axis < 3; ++axis) {
            const bool low = full[x][y][z], high = full[x + (axis == 0)][y + (axis == 1)][z + (axis == 2)];
            if (low != high) add_face({x, y, z}, axis, high);
          }
    if (far) add_far();
  }
  const Surface& surface() const { return surface_; }

 private:
  static constexpr int edge = 6;

  // Between a cube and the next one on the axis.
  void add_face(std::array<int, 3> at, int axis, bool turned) {
    ++at[static_cast<std::size_t>(axis)];
    std::uint32_t corner[4];
    for (int k = 0; k < 4; ++k) {
      std::array<int, 3> place = at;
      place[static_cast<std::size_t>((axis + 1) % 3)] += k == 1 || k == 2;
      place[static_cast<std::size_t>((axis + 2) % 3)] += k >= 2;
      corner[k] = vertex(place);
    }
    if (turned) std::swap(corner[1], corner[3]);
    surface_.corners.insert(surface_.corners.end(), {corner[0], corner[1], corner[2], corner[0], corner[2], corner[3]});
  }
  std::uint32_t vertex(const std::array<int, 3>& place) {
    const auto [at, is_new] = number_.emplace(place, static_cast<std::uint32_t>(surface_.vertices.size()));
    if (is_new) {
      const auto x = static_cast<double>(place[0]), y = static_cast<double>(place[1]),
                 z = static_cast<double>(place[2]);
      surface_.vertices.push_back({.at = {x * side_, y * side_, z * side_}, .id = PointId{at->second}, .tile = {}});
    }
    return at->second;
  }
  // A tetrahedron so far away that floats take all the rest for one place.
  void add_far() {
    const auto first = static_cast<std::uint32_t>(surface_.vertices.size());
    for (const Point& at : {Point{1e9, 0, 0}, {2e9, 0, 0}, {1e9, 1e9, 0}, {1e9, 0, 1e9}})
      surface_.vertices.push_back({.at = at, .id = PointId{surface_.vertices.size()}, .tile = {}});
    for (const std::uint32_t corner : {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}) surface_.corners.push_back(first + corner);
  }

  double side_;
  Surface surface_;
  std::map<std::array<int, 3>, std::uint32_t> number_;
};

// As levels are made: parts are cut, made coarser, joined, and made coarser again.
void check_levels(std::mt19937& dice, const Surface& whole) {
  std::vector<Surface> parts;
  for (const Surface& half : quarters(whole, 3))
    for (Surface& part : quarters(half, 3)) parts.push_back(std::move(part));
  while (parts.size() > 1) {
    std::vector<Surface> joined;
    for (std::size_t i = 0; i < parts.size(); i += 2) {
      std::vector<const Surface*> pair;
      for (std::size_t j = i; j < std::min(i + 2, parts.size()); ++j) pair.push_back(&parts[j]);
      const Surface fine = join(pair);
      Surface coarse = simplify(fine, std::uniform_int_distribution<std::size_t>(1, fine.triangles())(dice));
      ASSERT_EQ(border_of(coarse), border_of(fine));
      joined.push_back(std::move(coarse));
    }
    parts = std::move(joined);
  }
  ASSERT_EQ(border_of(parts.front()), Chain());
}

TEST(Levels, BordersStayHoweverSurfacesTouchThemselves) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 dice(seed);
    check_levels(dice, Cubes(dice, 1, false).surface());
    if (HasFatalFailure()) return;
  }
}

TEST(Levels, BordersStayWhereFloatsKnowOnePlaceOnly) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 dice(seed);
    check_levels(dice, Cubes(dice, 1e-3, true).surface());
    if (HasFatalFailure()) return;
  }
}

// A ball, whose vertices are all at 1.
Surface ball(int rings) {
  Surface surface;
  const int around = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring)
    for (int k = 0; k < around; ++k) {
      const double polar = M_PI * ring / rings, turn = 2 * M_PI * k / around;
      surface.vertices.push_back(
          {.at = {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)},
           .id = PointId{surface.vertices.size()},
           .tile = {}});
    }
  for (int ring = 0; ring < rings; ++ring)
    for (int k = 0; k < around; ++k) {
      const auto at = [&](int down, int right) {
        return static_cast<std::uint32_t>((ring + down) * around + (k + right) % around);
      };
      surface.corners.insert(surface.corners.end(), {at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)});
    }
  return surface;
}

TEST(Levels, DistancesAreThoseToAllOfTheSurface) {
  const Surface fine = ball(40);
  Surface flat;  // both sides of a square, seen from inside of the ball
  for (const Point& at : {Point{-2, -2, 0.25}, {2, -2, 0.25}, {2, 2, 0.25}, {-2, 2, 0.25}})
    flat.vertices.push_back({.at = at, .id = PointId{flat.vertices.size()}, .tile = {}});
  flat.corners = {0, 1, 2, 0, 2, 3};
  double sum = 0;
  for (const SurfaceVertex& v : fine.vertices) sum += (v.at.z - 0.25) * (v.at.z - 0.25);
  EXPECT_NEAR(distance_error(fine, flat), std::sqrt(sum / static_cast<double>(fine.vertices.size())), 1e-12);
  // Beside its edges and corners.
  Surface small = flat;
  for (SurfaceVertex& v : small.vertices) v.at = {v.at.x / 20, v.at.y / 20, 0};
  sum = 0;
  for (const SurfaceVertex& v : fine.vertices) {
    const double x = std::max(std::abs(v.at.x) - 0.1, 0.0), y = std::max(std::abs(v.at.y) - 0.1, 0.0);
    sum += x * x + y * y + v.at.z * v.at.z;
  }
  EXPECT_NEAR(distance_error(fine, small), std::sqrt(sum / static_cast<double>(fine.vertices.size())), 1e-12);
}

TEST(Levels, ABallThatIsMadeCoarserIsOffByWhatItsFacetsCutAway) {
  const Surface fine = ball(60);
  double before = 0;
  for (const std::size_t triangles : {6000U, 2000U, 500U}) {
    const Surface coarse = simplify(fine, triangles);
    EXPECT_LE(coarse.triangles(), triangles);
    EXPECT_EQ(border_of(coarse), border_of(fine));
    const double off = distance_error(fine, coarse);
    EXPECT_GT(off, before);
    EXPECT_LT(off, 16.0 / static_cast<double>(triangles));  // a facet's area is about 4 pi by their number
    before = off;
  }
}

}  // namespace
}  // namespace tessera::tileset

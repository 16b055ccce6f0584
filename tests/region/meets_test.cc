// Whether cells meet boxes, against clipping of segments in rational numbers: two convex bodies have a point in common
// if and only if an edge of one has one with the other.
#include "src/result/region/meets.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <random>
#include <span>
#include <vector>

#include "src/geometry/predicates/exact/predicates.h"

namespace tessera {
namespace {

using Number =
    boost::multiprecision::number<boost::multiprecision::cpp_rational_backend, boost::multiprecision::et_off>;
using Cell = std::vector<Point>;

// What of a segment, from 0 to 1, is where linear functions are not negative.
struct Clipped {
  Number begin = 0, end = 1;
  bool empty = false;
  // `from`, `to`: the function at the ends.
  void clip(const Number& from, const Number& to) {
    if (from < 0 && to < 0) empty = true;
    if (from < 0 && to >= 0) begin = std::max<Number>(begin, from / (from - to));
    if (from >= 0 && to < 0) end = std::min<Number>(end, from / (from - to));
    empty |= begin > end;
  }
};

Number side(const Cell& cell) {
  const auto minus = [&](std::size_t i, int axis) { return Number(cell[i][axis]) - Number(cell[0][axis]); };
  if (cell.size() == 3) return minus(1, 0) * minus(2, 1) - minus(1, 1) * minus(2, 0);
  Number sum = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    sum += minus(1, i) * (minus(2, j) * minus(3, k) - minus(2, k) * minus(3, j));
  }
  return sum;
}

bool edge_meets_box(const Point& a, const Point& b, const Bounds& box, int dimension) {
  Clipped clipped;
  for (int axis = 0; axis < dimension; ++axis) {
    clipped.clip(Number(a[axis]) - Number(box.lo[axis]), Number(b[axis]) - Number(box.lo[axis]));
    clipped.clip(Number(box.hi[axis]) - Number(a[axis]), Number(box.hi[axis]) - Number(b[axis]));
  }
  return !clipped.empty;
}

bool edge_meets_cell(const Point& a, const Point& b, const Cell& cell) {
  Clipped clipped;
  for (std::size_t k = 0; k < cell.size(); ++k) {
    Cell with_a = cell, with_b = cell;
    with_a[k] = a;
    with_b[k] = b;
    clipped.clip(side(with_a), side(with_b));
  }
  return !clipped.empty;
}

bool expected(const Cell& cell, const Bounds& box) {
  const int dimension = static_cast<int>(cell.size()) - 1;
  for (const Point& a : cell)
    for (const Point& b : cell)
      if (edge_meets_box(a, b, box, dimension)) return true;
  const int corners = 1 << dimension;
  const auto corner = [&](int i) {
    Point p;
    for (int axis = 0; axis < dimension; ++axis) p[axis] = (i >> axis & 1) != 0 ? box.hi[axis] : box.lo[axis];
    return p;
  };
  for (int i = 0; i < corners; ++i)
    for (int axis = 0; axis < dimension; ++axis)
      if (edge_meets_cell(corner(i), corner(i ^ 1 << axis), cell)) return true;
  return false;
}

class CellsAndBoxes : public testing::TestWithParam<int> {};

// On small lattices most of what meets only touches: by a vertex, an edge, a facet. Others are off by one bit.
TEST_P(CellsAndBoxes, MeetAsInRationalNumbers) {
  const int dimension = GetParam();
  std::mt19937_64 random(static_cast<std::uint64_t>(dimension));
  int met = 0, cases = 0;
  while (cases < (dimension == 2 ? 6000 : 800)) {
    const bool off = random() % 4 == 0;
    const auto coordinate = [&] {
      const double at = static_cast<double>(random() % 7) - 3;
      return off ? std::nextafter(at * 0.1, random() % 2 == 0 ? 9 : -9) : at;
    };
    Cell cell(static_cast<std::size_t>(dimension) + 1);
    Bounds box;
    for (int axis = 0; axis < dimension; ++axis) {
      for (Point& p : cell) p[axis] = coordinate();
      const double a = coordinate(), b = random() % 3 == 0 ? a : coordinate();
      box.lo[axis] = std::min(a, b);
      box.hi[axis] = std::max(a, b);
    }
    const Number volume = side(cell);
    if (volume == 0) continue;
    if (volume < 0) std::swap(cell[0], cell[1]);
    ++cases;
    const bool truth = expected(cell, box);
    met += truth;
    ASSERT_EQ(meets(cell, box), truth) << "case " << cases;
  }
  EXPECT_GT(met, cases / 10);
  EXPECT_LT(met, cases * 9 / 10);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, CellsAndBoxes, testing::Values(2, 3));

}  // namespace
}  // namespace tessera

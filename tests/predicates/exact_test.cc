// The exact predicates: value, symmetries, and the stage that decided, against exact rational arithmetic.
#include "src/geometry/predicates/exact/predicates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "src/geometry/predicates/independent/predicates.h"

namespace tessera::testing {
namespace {

using boost::multiprecision::cpp_rational;
using exact::PredicateStage;
using Rng = std::mt19937_64;
using Matrix = std::vector<std::vector<cpp_rational>>;

cpp_rational rational(double v) {
  int exponent = 0;
  const double mantissa = std::frexp(v, &exponent);  // also for denormals
  boost::multiprecision::cpp_int whole(static_cast<std::int64_t>(std::ldexp(mantissa, 53)));
  exponent -= 53;
  if (exponent >= 0) return cpp_rational(whole << exponent);
  return cpp_rational(whole, boost::multiprecision::cpp_int(1) << -exponent);
}

cpp_rational determinant(const Matrix& m) {
  if (m.size() == 1) return m[0][0];
  cpp_rational sum = 0;
  for (std::size_t row = 0; row < m.size(); ++row) {
    Matrix rest;
    for (std::size_t i = 0; i < m.size(); ++i) {
      if (i != row) rest.emplace_back(m[i].begin() + 1, m[i].end());
    }
    const cpp_rational term = m[row][0] * determinant(rest);
    row % 2 == 0 ? sum += term : sum -= term;
  }
  return sum;
}

// The homogeneous determinant of rows (1, coordinates, lift), by definition.
template <std::size_t N>
int reference(const std::array<Point, N>& points, int dimension, bool lifted) {
  Matrix m;
  for (const Point& p : points) {
    std::vector<cpp_rational> row{1};
    cpp_rational lift = 0;
    for (int k = 0; k < dimension; ++k) {
      row.push_back(rational(p[k]));
      lift += row.back() * row.back();
    }
    if (lifted) row.push_back(lift);
    m.push_back(row);
  }
  const int sign = determinant(m).sign();
  // A query high above the paraboloid, that is outside the circle or sphere, makes the lifted determinant positive.
  return lifted ? -sign : sign;
}

// A predicate of N points, and the determinant whose sign it is.
template <std::size_t N, int d, bool lifted, auto staged_sign, auto plain_sign>
struct Subject {
  static constexpr std::size_t n = N;
  static constexpr int dimension = d;
  static exact::Staged staged(const std::array<Point, n>& p) { return std::apply(staged_sign, p); }
  static int sign(const std::array<Point, n>& p) { return std::apply(plain_sign, p); }
  static int expected(const std::array<Point, n>& p) { return reference(p, d, lifted); }
  static std::string name() {
    if (lifted) return d == 2 ? "in_circle_2" : "in_sphere_3";
    return d == 2 ? "orientation_2" : "orientation_3";
  }
};
using Orientation2 = Subject<3, 2, false, exact::orientation_2_staged, exact::orientation_2>;
using Orientation3 = Subject<4, 3, false, exact::orientation_3_staged, exact::orientation_3>;
using InCircle2 = Subject<4, 2, true, exact::in_circle_2_staged, exact::in_circle_2>;
using InSphere3 = Subject<5, 3, true, exact::in_sphere_3_staged, exact::in_sphere_3>;

// Checks value and antisymmetry under each swap, and counts the stages.
template <class Predicate>
void check(std::array<Point, Predicate::n> p, std::map<PredicateStage, int>& stages) {
  const int expected = Predicate::expected(p);
  const exact::Staged staged = Predicate::staged(p);
  ++stages[staged.stage];
  ASSERT_EQ(staged.sign, expected) << Predicate::name();
  ASSERT_EQ(Predicate::sign(p), expected) << Predicate::name();
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::swap(p[i], p[j]);
      ASSERT_EQ(Predicate::sign(p), -expected) << Predicate::name() << " with " << i << " and " << j << " exchanged";
      std::swap(p[i], p[j]);
    }
  }
}

template <class Predicate>
class ExactPredicate : public ::testing::Test {
 protected:
  using Points = std::array<Point, Predicate::n>;
  template <class Coordinate>
  std::map<PredicateStage, int> check_many(int rounds, Coordinate&& coordinate) {
    std::map<PredicateStage, int> stages;
    for (int round = 0; round < rounds && !this->HasFatalFailure(); ++round) {
      Points p;
      for (Point& q : p) {
        for (int k = 0; k < 3; ++k) q[k] = coordinate(k);
      }
      check<Predicate>(p, stages);
    }
    return stages;
  }
  Rng rng_{7};
  double unit() { return std::uniform_real_distribution<>(0, 1)(rng_); }
  double of_any_exponent() {
    double v = std::nan("");
    while (!std::isfinite(v)) v = std::bit_cast<double>(rng_());
    return v;
  }
  int below(int n) { return static_cast<int>(rng_() % static_cast<std::uint64_t>(n)); }
};
using Predicates = ::testing::Types<Orientation2, Orientation3, InCircle2, InSphere3>;
struct Names {
  template <class T>
  static std::string GetName(int) {
    return T::name();
  }
};
TYPED_TEST_SUITE(ExactPredicate, Predicates, Names);

TYPED_TEST(ExactPredicate, IsDecidedByTheFilterForPointsInGeneralPosition) {
  auto stages = this->check_many(2000, [&](int) { return this->unit(); });
  EXPECT_EQ(stages[PredicateStage::filter], 2000);
}

TYPED_TEST(ExactPredicate, IsDecidedByTheFilterNearlyAlwaysOnCentimetresFarFromTheOrigin) {
  auto stages = this->check_many(2000, [&](int k) { return (k == 0 ? 6.8e6 : 3e5) + this->below(200) * 0.01; });
  EXPECT_GT(stages[PredicateStage::filter], 1950);
  EXPECT_EQ(stages[PredicateStage::wide] + stages[PredicateStage::big], 0);
}

TYPED_TEST(ExactPredicate, IsDecidedInIntegersForTiesOfMillimetresFarFromTheOrigin) {
  // Steps of 1e-3 around 6.8e6, few of them: repeated coordinates make true ties.
  auto stages = this->check_many(2000, [&](int) { return 6.8e6 + this->below(3) * 1e-3; });
  EXPECT_GT(stages[TypeParam::n > 3 ? PredicateStage::integer : PredicateStage::lattice],
            50);  // 22 bits: enough for areas in doubles
  EXPECT_EQ(stages[PredicateStage::wide] + stages[PredicateStage::big], 0);
}

TYPED_TEST(ExactPredicate, IsDecidedWithoutRoundingForTiesOfASmallLattice) {
  for (const double step : {1.0, 0x1p-100, 0x1p140}) {
    auto stages = this->check_many(2000, [&](int) { return step * this->below(3); });
    EXPECT_GT(stages[PredicateStage::lattice], 300);
    EXPECT_EQ(stages[PredicateStage::filter] + stages[PredicateStage::lattice], 2000);
  }
}

TYPED_TEST(ExactPredicate, IsDecidedInWideIntegersForTiesWhoseDifferencesAreRounded) {
  // 1 and 2^-60 have no exact difference; copies of both axes make ties.
  const std::array<double, 4> values{1, 0x1p-60, 1 + 0x1p-52, -0x1.8p-61};
  auto stages = this->check_many(2000, [&](int) { return values[this->below(4)]; });
  EXPECT_GT(stages[PredicateStage::wide], 100);
  EXPECT_EQ(stages[PredicateStage::big], 0);
}

// Any finite double: one product exceeds all others by far.
TYPED_TEST(ExactPredicate, IsDecidedWithExponentsOfAnySizeForPointsThatHaveThem) {
  auto stages = this->check_many(80, [&](int) { return this->of_any_exponent(); });
  EXPECT_GT(stages[PredicateStage::any_exponent], TypeParam::n > 3 ? 50 : 30);
  EXPECT_EQ(stages[PredicateStage::big], 0);
}

TYPED_TEST(ExactPredicate, IsDecidedWithExponentsOfAnySizeForExponentialSpacing) {
  auto stages = this->check_many(80, [&](int) {
    const double v = std::exp(this->unit() * 600 - 300);
    return this->below(2) ? v : -v;
  });
  EXPECT_GT(stages[PredicateStage::any_exponent], TypeParam::n > 3 ? 40 : 3);
  EXPECT_LT(stages[PredicateStage::big], 5);
}

// A coordinate that two points have in common, and products that differ by one unit in the last place: what exponents
// of any size cannot tell is told by integers, and never wrongly.
TYPED_TEST(ExactPredicate, IsExactForNearTiesOfAnyExponent) {
  for (int round = 0; round < 10; ++round) {
    std::array<double, 4> values;
    for (double& v : values) v = this->of_any_exponent();
    this->check_many(8, [&](int) {
      const double v = values[static_cast<std::size_t>(this->below(4))], moves = this->below(8);
      return moves == 0 ? std::nextafter(v, 0) : moves == 1 ? v / 2 : moves == 2 ? -v : v;
    });
  }
}

// A lattice in a plane, and points next to none beside it: each axis spans few bits, all together thousands.
TYPED_TEST(ExactPredicate, IsDecidedByAxisForALatticeInAPlaneAndPointsThatAreHardlyBesideIt) {
  for (const double height : {1e-300, 1e300, 5e-324}) {
    auto stages = this->check_many(
        200, [&](int k) { return k == TypeParam::dimension - 1 ? height * this->below(2) : 1.0 * this->below(6); });
    EXPECT_GT(stages[PredicateStage::axes], 5);
    EXPECT_EQ(stages[PredicateStage::big], 0);
  }
}

TYPED_TEST(ExactPredicate, IsDecidedInBigIntegersWhenMagnitudesAreFarApart) {
  const std::array<double, 6> values{1e300, 1e-300, 0, -1e300, 1, -1e-300};
  auto stages = this->check_many(200, [&](int) { return values[this->below(6)]; });
  EXPECT_GT(stages[PredicateStage::big], 15);
}

TYPED_TEST(ExactPredicate, IsExactForDenormalsAndZerosOfBothSigns) {
  constexpr double least = std::numeric_limits<double>::denorm_min();
  const std::array<double, 6> values{0.0, -0.0, least, -least, 3 * least, std::numeric_limits<double>::min()};
  auto stages = this->check_many(1000, [&](int) { return values[this->below(6)]; });
  EXPECT_EQ(stages[PredicateStage::filter], 0);
  EXPECT_GT(stages[PredicateStage::integer], 500);
}

TYPED_TEST(ExactPredicate, IsExactAtTheEndsOfTheExponentRange) {
  constexpr double greatest = std::numeric_limits<double>::max();
  const std::array<double, 8> values{greatest, -greatest, greatest / 2, -greatest / 2, 1e300, -3e307, 0, 1e308};
  this->check_many(500, [&](int) { return values[this->below(8)]; });
}

TYPED_TEST(ExactPredicate, IsExactWhateverTheMagnitudes) {
  for (const int range : {40, 130, 400, 2000}) {
    this->check_many(150, [&](int) {
      const double mantissa = this->below(3) == 0 ? 1 : this->unit() + 0.5;
      return std::ldexp(this->below(2) ? mantissa : -mantissa, this->below(range) - range / 2);
    });
  }
}

// Where the lattice stage ends: differences of exactly as many bits as it takes, and one more.
TYPED_TEST(ExactPredicate, IsExactAtTheEndOfTheLatticeStage) {
  for (int bits = 8; bits < 28; ++bits) {
    const double side = std::ldexp(1, bits);
    auto stages = this->check_many(100, [&](int) { return this->below(2) ? side - this->below(2) : this->below(2); });
    EXPECT_EQ(stages[PredicateStage::wide] + stages[PredicateStage::big], 0);
  }
}

// One unit in the last place decides: the filter must never be sure of a wrong sign.
TYPED_TEST(ExactPredicate, IsExactForPointsAnUlpAwayFromATie) {
  for (const double origin : {0.0, 0.1, 6.8e6, -1e15}) {
    this->check_many(400, [&](int) {
      double v = origin + this->below(3) * 0.25;
      const int moves = this->below(8);
      if (moves == 0) v = std::nextafter(v, 1e300);
      if (moves == 1) v = std::nextafter(v, -1e300);
      return v;
    });
  }
}

TYPED_TEST(ExactPredicate, IsExactForPointsAnUlpAwayFromATieAtEveryScale) {
  for (int exponent = -1070; exponent < 1020; exponent += 30) {
    this->check_many(60, [&](int) {
      double v = std::ldexp(1.0 + this->below(3), exponent);
      if (this->below(6) == 0) v = std::nextafter(v, 1e308);
      return v;
    });
  }
}

template <std::size_t N>
std::array<Point, N> lattice_points(Rng& rng, int side, int dimension) {
  std::array<Point, N> points;
  for (std::size_t i = 0; i < N; ++i) {
    do {
      for (int k = 0; k < dimension; ++k) points[i][k] = 0.1 * static_cast<double>(rng() % std::uint64_t(side));
    } while (std::find(points.begin(), points.begin() + i, points[i]) != points.begin() + i);
  }
  return points;
}

TEST(Perturbed, AgreesWithThePredicatesThatVerifyUses) {
  Rng rng(3);
  for (int round = 0; round < 100000; ++round) {
    auto p = lattice_points<5>(rng, 4, 3);
    if (exact::orientation_3(p[0], p[1], p[2], p[3]) < 0) std::swap(p[0], p[1]);
    ASSERT_EQ(exact::orientation_3(p[0], p[1], p[2], p[3]), independent::orientation_3(p[0], p[1], p[2], p[3]));
    ASSERT_EQ(exact::in_sphere_perturbed_3(p[0], p[1], p[2], p[3], p[4]),
              independent::in_sphere_perturbed_3(p[0], p[1], p[2], p[3], p[4]));
    auto q = lattice_points<4>(rng, 4, 2);
    if (exact::orientation_2(q[0], q[1], q[2]) < 0) std::swap(q[0], q[1]);
    ASSERT_EQ(exact::in_circle_perturbed_2(q[0], q[1], q[2], q[3]),
              independent::in_circle_perturbed_2(q[0], q[1], q[2], q[3]));
  }
}

// The plane z = 0 holds the order and the circles of 2D; other planes hold those of its images.
TEST(CoplanarIncircle, IsTheIncircleOfThePlaneWhateverTheOrientation) {
  Rng rng(4);
  for (int round = 0; round < 50000; ++round) {
    auto p = lattice_points<4>(rng, 5, 2);
    const int turn = exact::orientation_2(p[0], p[1], p[2]);
    if (turn == 0) continue;
    const int side = turn * exact::in_circle_2(p[0], p[1], p[2], p[3]);
    ASSERT_EQ(exact::coplanar_in_circle(p[0], p[1], p[2], p[3]), side);
    if (turn > 0) {
      ASSERT_EQ(exact::coplanar_in_circle_perturbed(p[0], p[1], p[2], p[3]),
                exact::in_circle_perturbed_2(p[0], p[1], p[2], p[3]));
    }
    ASSERT_EQ(exact::coplanar_in_circle_perturbed(p[0], p[1], p[2], p[3]),
              exact::coplanar_in_circle_perturbed(p[1], p[0], p[2], p[3]));
    auto turned = p;  // the planes x = 0 and y = 0, in the same lexicographic order
    for (std::size_t i = 0; i < 4; ++i) turned[i] = {0, p[i].x, p[i].y};
    ASSERT_EQ(exact::coplanar_in_circle(turned[0], turned[1], turned[2], turned[3]), side);
    ASSERT_EQ(exact::coplanar_in_circle_perturbed(turned[0], turned[1], turned[2], turned[3]),
              exact::coplanar_in_circle_perturbed(p[0], p[1], p[2], p[3]));
    for (std::size_t i = 0; i < 4; ++i) turned[i] = {p[i].x, 0, p[i].y};
    ASSERT_EQ(exact::coplanar_in_circle(turned[0], turned[1], turned[2], turned[3]), side);
    ASSERT_EQ(exact::coplanar_in_circle_perturbed(turned[0], turned[1], turned[2], turned[3]),
              exact::coplanar_in_circle_perturbed(p[0], p[1], p[2], p[3]));
  }
}

// In a slanted plane the circle is that of space: tell by the sphere through the triangle and a point off the plane,
// which meets the plane in that circle.
TEST(CoplanarIncircle, MeasuresDistanceInSpaceInASlantedPlane) {
  Rng rng(5);
  const std::array<std::array<Point, 2>, 3> bases{
      {{{{1, 0, 1}, {0, 1, 2}}}, {{{1, 1, 0}, {0, 0, 1}}}, {{{0, 1, 1}, {3, 0, -1}}}}};
  for (int round = 0; round < 30000; ++round) {
    const auto& [e, f] = bases[rng() % 3];
    std::array<Point, 4> p;
    for (std::size_t i = 0; i < 4; ++i) {
      const double s = static_cast<double>(rng() % 5), t = static_cast<double>(rng() % 5);
      p[i] = {s * e.x + t * f.x, s * e.y + t * f.y, s * e.z + t * f.z};
    }
    if (exact::coplanar_orientation(p[0], p[1], p[2]) == 0) continue;
    const Point apex{p[0].x + 1, p[0].y - 5, p[0].z + 7};
    const int positive = exact::orientation_3(p[0], p[1], p[2], apex);
    if (positive == 0) continue;
    ASSERT_EQ(exact::coplanar_in_circle(p[0], p[1], p[2], p[3]),
              positive * exact::in_sphere_3(p[0], p[1], p[2], apex, p[3]));
  }
}

}  // namespace
}  // namespace tessera::testing

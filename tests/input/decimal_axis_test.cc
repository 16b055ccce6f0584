// The coordinates of LAS files against exact rational arithmetic.
#include "src/input/las/decimal_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

namespace tessera {
namespace {

using boost::multiprecision::cpp_int;
using boost::multiprecision::cpp_rational;

cpp_rational power(int base, int exponent) {
  const cpp_int p = boost::multiprecision::pow(cpp_int(base), static_cast<unsigned>(std::abs(exponent)));
  return exponent < 0 ? cpp_rational(1, p) : cpp_rational(p);
}

// The shortest decimal that reads back as `value`, found by trying (the engine asks std::to_chars).
cpp_rational shortest_decimal(double value) {
  for (int digits = 0; digits <= 17; ++digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*e", digits, value);
    if (std::strtod(text, nullptr) != value) continue;
    std::string s = text;
    const auto e = s.find('e');
    std::string mantissa = s.substr(0, e);
    int exponent = std::atoi(s.c_str() + e + 1);
    if (const auto point = mantissa.find('.'); point != std::string::npos) {
      exponent -= static_cast<int>(mantissa.size() - point - 1);
      mantissa.erase(point, 1);
    }
    const bool negative = mantissa[0] == '-';
    if (negative) mantissa.erase(0, 1);
    mantissa.erase(0, std::min(mantissa.find_first_not_of('0'), mantissa.size() - 1));  // or it would be octal
    const cpp_rational r = cpp_rational(cpp_int(mantissa)) * power(10, exponent);
    return negative ? -r : r;
  }
  return 0;
}

cpp_rational exactly(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return cpp_rational(cpp_int(static_cast<std::int64_t>(std::ldexp(mantissa, 53)))) * power(2, exponent - 53);
}

bool is_even(double value) { return (std::bit_cast<std::uint64_t>(value) & 1) == 0; }

// No double is nearer to `exact`, and of two equally near ones `value` is the even one.
testing::AssertionResult is_nearest(double value, const cpp_rational& exact) {
  const cpp_rational distance = abs(exact - exactly(value));
  for (const double other : {std::nextafter(value, -DBL_MAX), std::nextafter(value, DBL_MAX)}) {
    const cpp_rational other_distance = abs(exact - exactly(other));
    if (other_distance < distance || (other_distance == distance && other != value && !is_even(value)))
      return testing::AssertionFailure() << value << " is not the nearest double, " << other << " is nearer";
  }
  return testing::AssertionSuccess();
}

void check(double scale, double offset, std::int32_t integer) {
  const cpp_rational exact = integer * shortest_decimal(scale) + shortest_decimal(offset);
  if (abs(exact) > exactly(DBL_MAX)) return;
  const double value = DecimalAxis(scale, offset)(integer);
  ASSERT_TRUE(is_nearest(value, exact)) << "scale " << scale << " offset " << offset << " integer " << integer;
}

const std::vector<double> scales{0.01,
                                 0.001,
                                 0.00025,
                                 1e-7,
                                 0.1,
                                 1,
                                 2,
                                 10,
                                 1e5,
                                 0.5,
                                 -0.01,
                                 1.029520741639058e-06,
                                 1.223078836992658e-06,
                                 1.3268845182207467e-07,
                                 9.205200000002516e-08,
                                 7.034700000006706e-08,
                                 0.0010000000000000002,
                                 1.0000000000000006e-05,
                                 1e-22,
                                 1e-23,
                                 1e-40,
                                 1e-300,
                                 1e300,
                                 5e-324,
                                 0.3048006096012192};
const std::vector<double> offsets{0,
                                  -0.0,
                                  515396,
                                  4918348,
                                  2324,
                                  393775.82306091185,
                                  3689071.9431220554,
                                  3107.8627,
                                  6328493.418841014,
                                  2069791.8284753433,
                                  0.1,
                                  49.02539999999999,
                                  1e22,
                                  1e23,
                                  -1e15,
                                  9007199254740994.0,
                                  1e300,
                                  5e-324,
                                  -0.7};

TEST(DecimalAxis, IsTheNearestDoubleToTheDecimalForScalesAndOffsetsOfRealAndAbsurdFiles) {
  std::mt19937_64 random(7);
  for (const double scale : scales)
    for (const double offset : offsets) {
      for (const std::int32_t integer : {0, 1, -1, 17, INT32_MAX, INT32_MIN, INT32_MIN + 1, 2097151, -2097152})
        check(scale, offset, integer);
      for (int i = 0; i < 40; ++i)
        check(scale, offset, static_cast<std::int32_t>(random() >> (32 + random() % 28)) * (i % 2 == 0 ? 1 : -1));
    }
}

TEST(DecimalAxis, IsTheNearestDoubleForRandomScalesAndOffsets) {
  std::mt19937_64 random(11);
  const auto draw = [&](double magnitude_max) {
    const double magnitude = magnitude_max * (2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1);
    const double raw = std::pow(10.0, magnitude) * (1 + static_cast<double>(random() >> 11) * 0x1p-53);
    // Half of them short decimals, as people choose them.
    char text[64];
    std::snprintf(text, sizeof text, "%.*e", static_cast<int>(random() % 18), raw);
    return std::strtod(text, nullptr);
  };
  for (int i = 0; i < 20000; ++i) {
    const double scale = draw(i % 10 == 0 ? 40 : 9), offset = draw(i % 10 == 0 ? 40 : 8);
    check(scale, i % 3 == 0 ? -offset : offset, static_cast<std::int32_t>(random()));
  }
}

TEST(DecimalAxis, RoundsTiesToEven) {
  // 2^53 + 1 and + 3 are halfway between doubles.
  EXPECT_EQ(DecimalAxis(1, 9007199254740992)(1), 9007199254740992);
  EXPECT_EQ(DecimalAxis(1, 9007199254740992)(3), 9007199254740996);
  EXPECT_EQ(DecimalAxis(-1, -9007199254740992)(3), -9007199254740996);
}

TEST(DecimalAxis, GivesOneDoubleForOneDecimalWhateverScaleAndOffset) {
  std::mt19937_64 random(3);
  const DecimalAxis plain(0.00025, 0), shifted(0.00025, 515396), odd(0.00025, 500000.25), finer(0.000125, 515396);
  int naive_differences = 0;
  for (int i = 0; i < 100000; ++i) {
    const auto k = static_cast<std::int32_t>(1'900'000'000 + random() % 240'000'000);  // stands for k * 0.00025
    const double there = plain(k);
    ASSERT_EQ(there, shifted(k - 2'061'584'000));
    ASSERT_EQ(there, odd(k - 2'000'001'000));
    ASSERT_EQ(there, finer(2 * (k - 2'061'584'000)));
    naive_differences += k * 0.00025 != (k - 2'061'584'000) * 0.00025 + 515396;
  }
  EXPECT_GT(naive_differences, 1000) << "with three roundings the point would depend on the file's offset";
}

}  // namespace
}  // namespace tessera

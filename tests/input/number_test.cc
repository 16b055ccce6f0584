#include "src/input/bytes/number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace tessera {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(ParseNumber, ReadsWhatPeopleWrite) {
  EXPECT_EQ(parse_number("12"), 12.0);
  EXPECT_EQ(parse_number("+12.5"), 12.5);
  EXPECT_EQ(parse_number("-.5e-3"), -0.0005);
  EXPECT_EQ(parse_number("1E+2"), 100.0);
  EXPECT_EQ(parse_number("0.1"), 0.1);
  EXPECT_EQ(parse_number("5e-324"), 5e-324);
  EXPECT_TRUE(std::isnan(*parse_number("nan")));
  EXPECT_EQ(parse_number("-INF"), -infinity);
}

TEST(ParseNumber, RefusesWhatIsNotWhollyANumber) {
  for (const char* text : {"", "+", "-", "+-1", "++1", "1x", "0x10", "1,5", " 1", "1 ", "e5", "1e", "abc"})
    EXPECT_FALSE(parse_number(text)) << text;
}

TEST(ParseNumber, RoundsBeyondTheRangeToInfinityAndZero) {
  EXPECT_EQ(parse_number("1e400"), infinity);
  EXPECT_EQ(parse_number("-1e400"), -infinity);
  EXPECT_EQ(parse_number("1" + std::string(400, '0')), infinity);
  EXPECT_EQ(parse_number("1e99999999999999999999"), infinity);
  EXPECT_EQ(parse_number("1e-400"), 0.0);
  EXPECT_EQ(parse_number("0." + std::string(400, '0') + "1"), 0.0);
  EXPECT_EQ(parse_number("1e-99999999999999999999"), 0.0);
  EXPECT_EQ(parse_number("0e99999999999999999999"), 0.0);
}

}  // namespace
}  // namespace tessera

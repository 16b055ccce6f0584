#include "src/job/arguments.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tessera {
namespace {

TEST(Arguments, CountsTakeDecimalSuffixes) {
  EXPECT_EQ(parse_count("0").value(), 0u);
  EXPECT_EQ(parse_count("500").value(), 500u);
  EXPECT_EQ(parse_count("10k").value(), 10'000u);
  EXPECT_EQ(parse_count("10K").value(), 10'000u);
  EXPECT_EQ(parse_count("1.5M").value(), 1'500'000u);
  EXPECT_EQ(parse_count("2G").value(), 2'000'000'000u);
  EXPECT_EQ(parse_count("0.001k").value(), 1u);
  EXPECT_EQ(parse_count("3.000").value(), 3u);
  EXPECT_EQ(parse_count("18446744073709551615").value(), 18446744073709551615u);
}

TEST(Arguments, CountsAreStrict) {
  for (const auto* text : {"", " 5", "5 ", "-1", "+1", "1e6", "1.5", "1.", ".5M", "5MB", "5m", "0x10", "M", "1,000",
                           "nan", "18446744073709551616", "99999999999999999999", "20000000000G", "1.0005k"}) {
    const auto count = parse_count(text);
    ASSERT_FALSE(count) << text;
    EXPECT_EQ(count.error().code, Errc::usage) << text;
    EXPECT_TRUE(count.error().where.starts_with("'" + std::string(text) + "'")) << count.error().where;
  }
}

TEST(Arguments, MemoryTakesBinarySuffixes) {
  EXPECT_EQ(parse_memory("1048576").value(), 1u << 20);
  EXPECT_EQ(parse_memory("1K").value(), 1024u);
  EXPECT_EQ(parse_memory("1k").value(), 1024u);
  EXPECT_EQ(parse_memory("800M").value(), 800u << 20);
  EXPECT_EQ(parse_memory("1.5G").value(), 1610612736u);
  EXPECT_EQ(parse_memory("2T").value(), std::uint64_t{2} << 40);
}

TEST(Arguments, MemoryIsStrict) {
  for (const auto* text :
       {"", "4GB", "4GiB", "4g", "1.5", "-4G", "4 G", "1.0000001G", "G", "16777216T", "99999999999999999999"}) {
    EXPECT_FALSE(parse_memory(text)) << text;
  }
}

TEST(Arguments, IntegersStayInTheirRange) {
  EXPECT_EQ(parse_integer("-3", -5, 5).value(), -3);
  for (const auto* text : {"", "6", "-6", "1.0", "1k", " 1", "99999999999999999999"}) {
    EXPECT_FALSE(parse_integer(text, -5, 5)) << text;
  }
}

TEST(Arguments, SwitchesAreTrueOrFalse) {
  EXPECT_TRUE(parse_switch("yes").value());
  EXPECT_FALSE(parse_switch("off").value());
  EXPECT_FALSE(parse_switch("maybe"));
  EXPECT_FALSE(parse_switch(""));
}

TEST(Arguments, CropOfFourNumbersLeavesZOpen) {
  const auto box = parse_crop("-1,-2.5,3e2,4", 3).value();
  EXPECT_EQ(box.lo.x, -1);
  EXPECT_EQ(box.lo.y, -2.5);
  EXPECT_EQ(box.hi.x, 300);
  EXPECT_EQ(box.hi.y, 4);
  EXPECT_TRUE(std::isinf(box.lo.z) && std::isinf(box.hi.z));
}

TEST(Arguments, CropOfSixNumbersIs3D) {
  const auto box = parse_crop("1,2,3,4,5,6", 3).value();
  EXPECT_EQ(box.lo, (Point{1, 2, 3}));
  EXPECT_EQ(box.hi, (Point{4, 5, 6}));
  EXPECT_FALSE(parse_crop("1,2,3,4,5,6", 2));
}

TEST(Arguments, CropRefusesWhatIsNoBox) {
  for (const auto* text :
       {"", "1,2,3", "1,2,3,4,5", "1,2,3,4,", "a,2,3,4", "5,2,3,4", "1,2,3,nan", "1,2,inf,4", "1 ,2,3,4"}) {
    EXPECT_FALSE(parse_crop(text, 3)) << text;
  }
}

TEST(Arguments, DistancesAreFiniteAndAboveZero) {
  EXPECT_EQ(parse_distance("0.25").value(), 0.25);
  EXPECT_EQ(parse_distance("1e3").value(), 1000);
  for (const auto* text : {"", "0", "-1", "nan", "inf", "1m", " 1"}) EXPECT_FALSE(parse_distance(text)) << text;
}

TEST(Arguments, ListsHaveNoEmptyPart) {
  EXPECT_EQ(parse_classes("2,9").value(), (std::vector<int>{2, 9}));
  EXPECT_EQ(parse_names("intensity,red").value(), (std::vector<std::string>{"intensity", "red"}));
  for (const auto* text : {"", "2,", ",2", "256", "-1", "ground"}) EXPECT_FALSE(parse_classes(text)) << text;
  for (const auto* text : {"", "a,", ",a", "a,,b"}) EXPECT_FALSE(parse_names(text)) << text;
}

}  // namespace
}  // namespace tessera

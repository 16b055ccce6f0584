#include "src/job/report/human.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Human, CountsHaveThreeDigits) {
  EXPECT_EQ(human_count(0), "0");
  EXPECT_EQ(human_count(999), "999");
  EXPECT_EQ(human_count(1000), "1.00 k");
  EXPECT_EQ(human_count(12'345), "12.3 k");
  EXPECT_EQ(human_count(999'600), "1.00 M");
  EXPECT_EQ(human_count(4'560'000), "4.56 M");
  EXPECT_EQ(human_count(~std::uint64_t{0}), "18.4 E");
}

TEST(Human, BytesAreBinary) {
  EXPECT_EQ(human_bytes(512), "512 B");
  EXPECT_EQ(human_bytes(1024), "1.00 KiB");
  EXPECT_EQ(human_bytes(std::uint64_t{3} << 29), "1.50 GiB");
}

TEST(Human, SecondsChangeTheirUnit) {
  EXPECT_EQ(human_seconds(0.423), "0.42 s");
  EXPECT_EQ(human_seconds(12.34), "12.3 s");
  EXPECT_EQ(human_seconds(184), "3 min 04 s");
  EXPECT_EQ(human_seconds(7500), "2 h 05 min");
  EXPECT_EQ(human_seconds(-1), "?");
}

TEST(Human, CoordinatesHaveTenDigits) {
  EXPECT_EQ(coordinate(6277500), "6277500");
  EXPECT_EQ(coordinate(0.1 + 0.2), "0.3");
  EXPECT_EQ(coordinate(-770500.25), "-770500.25");
}

TEST(Human, DigitsAreGrouped) {
  EXPECT_EQ(grouped(1), "1");
  EXPECT_EQ(grouped(123), "123");
  EXPECT_EQ(grouped(1234), "1 234");
  EXPECT_EQ(grouped(12'345'678), "12 345 678");
}

TEST(Human, MarkupIsEscaped) {
  EXPECT_EQ(escape_html("<a href='x'>&\"</a>"), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;&lt;/a&gt;");
}

// A page with one other byte is no UTF-8 as a whole.
TEST(Human, EscapedTextIsUtf8WhateverTheNameOfAFile) {
  EXPECT_EQ(escape_html("caf\xE9.las, caf\xC3\xA9.las"), "caf&#65533;.las, caf\xC3\xA9.las");
  EXPECT_EQ(escape_html("\xE2\x82"), "&#65533;&#65533;");
}

}  // namespace
}  // namespace tessera

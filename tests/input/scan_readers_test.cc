#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

const std::string identity = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
// A quarter of a turn about z, and a motion by (100, 200, 300): (x, y, z) becomes (100 - y, 200 + x, 300 + z).
const std::string turned = "100 200 300\n0 1 0\n-1 0 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n100 200 300 1\n";

std::string ptx_refusal(const std::string& text) { return sentence(read_text(text, "a.ptx")); }
std::string pts_refusal(const std::string& text) { return sentence(read_text(text, "a.pts")); }

TEST(PtxReader, MovesEachScanByItsMatrixAndSkipsPulsesWithoutEcho) {
  const std::string text = "2\n2\n" + identity + "1 2 3 0.5\n0 0 0 0.5\n4 5 6 0.25\n7 8.5 9 1\n" + "1\n3\n" + turned +
                           "1 2 3 0.125\n0 0 0 0.5\n0.5 0 0 0\n";
  const std::vector<Attribute> schema{{"intensity", AttributeType::f32},
                                      {"scan", AttributeType::u32},
                                      {"x_origin", AttributeType::f64},
                                      {"y_origin", AttributeType::f64},
                                      {"z_origin", AttributeType::f64}};
  const auto read = read_text(text, "a.ptx", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points,
            (std::vector<Point>{{1, 2, 3}, {4, 5, 6}, {7, 8.5, 9}, {98, 201, 303}, {100, 200.5, 300}}));
  EXPECT_EQ(read.value().info.format, "ptx");
  EXPECT_EQ(read.value().info.attributes, schema);
  EXPECT_FALSE(read.value().info.points);
  EXPECT_EQ(cell<float>(read.value(), schema, 3, 0), 0.125f);
  EXPECT_EQ(cell<std::uint32_t>(read.value(), schema, 2, 1), 0u);
  EXPECT_EQ(cell<std::uint32_t>(read.value(), schema, 4, 1), 1u);
  EXPECT_EQ(cell<double>(read.value(), schema, 2, 3), 0);
  EXPECT_EQ(cell<double>(read.value(), schema, 3, 2), 100);
  EXPECT_EQ(cell<double>(read.value(), schema, 4, 4), 300);
}

TEST(PtxReader, ReadsColoursIfTheFirstScanHasThem) {
  const std::vector<Attribute> schema{{"red", AttributeType::u8}, {"blue", AttributeType::u8}};
  const auto read = read_text("1\r\n2\r\n" + identity + "1 2 3 0.5 255 7 9\r\n4 5 6 0.5 1 2 3\r\n", "a.ptx", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 0, 0), 255);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 1, 1), 3);
  ASSERT_EQ(read.value().info.attributes.size(), 8u);
}

TEST(PtxReader, WhatMakesNoSenseIsRefusedWithItsLine) {
  EXPECT_EQ(ptx_refusal("1 2 3\n4 5 6\n"),
            "a.ptx, line 1: a scan of a PTX file begins here, and this line is not its number of columns");
  EXPECT_EQ(ptx_refusal("1\n-2\n"),
            "a.ptx, line 2: a scan of a PTX file begins here, and this line is not its number of rows");
  EXPECT_EQ(ptx_refusal("1\n1\n0 0 0\n1 0 0\n"), "a.ptx, line 5: the file ends within the header of a scan");
  EXPECT_EQ(ptx_refusal("1\n1\n0 0\n"),
            "a.ptx, line 3: the scanner's position is a line of 3 numbers, but this line has 2");
  EXPECT_EQ(ptx_refusal("1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 nan 0\n"),
            "a.ptx, line 9: a row of the scan's matrix has 'nan', which is not a finite number");
  EXPECT_EQ(ptx_refusal("1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 1\n0 0 0 1\n1 2 3 0\n"),
            "a.ptx, line 10: the matrix of the scan is not a motion: its last column is not 0 0 0 1");
  EXPECT_EQ(ptx_refusal("1\n3\n" + identity + "1 2 3 0.5\n1 2 4 0.5\n"),
            "a.ptx, line 13: the file ends 1 points before the end of scan 0");
  EXPECT_EQ(ptx_refusal("1\n1\n" + identity + "1 2 3\n"),
            "a.ptx, line 11: a point of a PTX file is a line of 4 or 7 numbers, but this line has 3");
  EXPECT_EQ(ptx_refusal("1\n1\n" + identity + "1 b 3 0.5\n"), "a.ptx, line 11: y is 'b', not a number");
}

TEST(PtsReader, ReadsPartsWithTheirNumberOfPoints) {
  const std::vector<Attribute> schema{{"intensity", AttributeType::f64},
                                      {"red", AttributeType::u8},
                                      {"green", AttributeType::u8},
                                      {"blue", AttributeType::u8}};
  const auto read = read_text("2\n1 2 3 -1500 10 20 30\n4 5 6 2047 1 2 255\n\n1\n7 8 9 0 0 0 0\n", "a.pts", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}));
  EXPECT_EQ(read.value().info.attributes, schema);
  EXPECT_EQ(cell<double>(read.value(), schema, 0, 0), -1500);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 1, 3), 255);
  EXPECT_EQ(read_text("1\n1 2 3\n", "a.pts").value().info.attributes.size(), 0u);
  EXPECT_EQ(read_text("1\n1 2 3 4\n", "a.pts").value().info.attributes.size(), 1u);
  EXPECT_EQ(read_text("1\n1 2 3 4 5 6\n", "a.pts").value().info.attributes.size(), 3u);
}

TEST(PtsReader, AFileWithoutNumberOfPointsIsText) {
  const auto read = read_text("1 2 3 4\n5 6 7 8\n", "a.pts");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.format, "xyz");
  EXPECT_EQ(read.value().points.size(), 2u);
}

TEST(PtsReader, WhatMakesNoSenseIsRefusedWithItsLine) {
  EXPECT_EQ(pts_refusal("3\n1 2 3\n4 5 6\n"), "a.pts, line 4: the file ends 1 points before the end of the last part");
  EXPECT_EQ(pts_refusal("1\n1 2 3\n4 5 6\n"), "a.pts, line 3: the number of points of the next part is expected here");
  EXPECT_EQ(pts_refusal("2\n1 2 3\n4 5\n"),
            "a.pts, line 3: a point is a line of 3 numbers in this file, but this line has 2");
  EXPECT_EQ(pts_refusal("1\n1 2 3 4 5\n"),
            "a.pts, line 2: a point of a PTS file is a line of 3, 4, 6 or 7 numbers, but this line has 5");
  EXPECT_EQ(pts_refusal("1\n"), "a.pts, line 2: the file ends before the first point");
  EXPECT_EQ(pts_refusal("2\n1 2 3\nx 5 6\n"), "a.pts, line 3: x is 'x', not a number");
}

}  // namespace
}  // namespace tessera::testing_io

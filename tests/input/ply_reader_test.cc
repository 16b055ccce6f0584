#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

const std::vector<Point> two_points{{1, 2.5, -3}, {4, 5, 6}};

// Two vertices with properties in an odd order, a list among them, behind two other elements.
Bytes mixed_ply(bool big) {
  Bytes b = bytes_of(std::string("ply\nformat binary_") + (big ? "big" : "little") +
                     "_endian 1.0\ncomment made by hand\nobj_info none\n"
                     "element camera 2\nproperty double f\nproperty uchar k\n"
                     "element face 2\nproperty list uchar int vertex_indices\nproperty short flag\n"
                     "element vertex 2\nproperty uchar red\nproperty float z\nproperty list ushort float weights\n"
                     "property double x\nproperty int y2\nproperty double y\n"
                     "element tail 1\nproperty int t\nend_header\n");
  for (int i = 0; i < 2; ++i) {
    push(b, 1.5, big);
    push<std::uint8_t>(b, 7, big);
  }
  for (const int corners : {3, 0}) {
    push(b, static_cast<std::uint8_t>(corners), big);
    for (int c = 0; c < corners; ++c) push(b, c, big);
    push<std::int16_t>(b, -1, big);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    push(b, static_cast<std::uint8_t>(200 + i), big);
    push(b, static_cast<float>(two_points[i].z), big);
    push(b, static_cast<std::uint16_t>(2 * i), big);
    for (std::size_t k = 0; k < 2 * i; ++k) push(b, 0.5f, big);
    push(b, two_points[i].x, big);
    push(b, static_cast<std::int32_t>(-5), big);
    push(b, two_points[i].y, big);
  }
  push(b, 99, big);
  return b;
}

TEST(PlyReader, FindsVerticesAmongOtherElementsListsAndPropertiesInBothByteOrders) {
  const std::vector<Attribute> schema{{"y2", AttributeType::i32}, {"red", AttributeType::f64}};
  for (const bool big : {false, true}) {
    const auto read = read_bytes(mixed_ply(big), "a.ply", schema);
    ASSERT_EQ(sentence(read), "");
    EXPECT_EQ(read.value().points, two_points);
    EXPECT_EQ(read.value().info.points, 2u);
    EXPECT_EQ(read.value().info.attributes,
              (std::vector<Attribute>{{"red", AttributeType::u8}, {"y2", AttributeType::i32}}));
    EXPECT_EQ(cell<std::int32_t>(read.value(), schema, 1, 0), -5);
    EXPECT_EQ(cell<double>(read.value(), schema, 1, 1), 201.0);
  }
}

Bytes plain_ply(bool big, const std::string& type) {
  Bytes b = bytes_of("ply\r\nformat binary_" + std::string(big ? "big" : "little") +
                     "_endian 1.0\r\nelement vertex 2\r\nproperty " + type + " x\r\nproperty " + type +
                     " y\r\nproperty " + type + " z\r\nproperty ushort intensity\r\nend_header\r\n");
  for (const auto& p : two_points) {
    for (int axis = 0; axis < 3; ++axis) {
      if (type == "double" || type == "float64") push(b, p[axis], big);
      if (type == "float" || type == "float32") push(b, static_cast<float>(p[axis]), big);
      if (type == "int") push(b, static_cast<std::int32_t>(p[axis]), big);
      if (type == "uchar") push(b, static_cast<std::uint8_t>(std::abs(p[axis])), big);
    }
    push<std::uint16_t>(b, 513, big);
  }
  return b;
}

TEST(PlyReader, ReadsFloatsDoublesAndIntegersAndSeeks) {
  const std::vector<Attribute> schema{{"intensity", AttributeType::u16}};
  for (const bool big : {false, true}) {
    for (const char* type : {"double", "float", "float64", "float32"}) {
      const auto read = read_bytes(plain_ply(big, type), "a.ply", schema);
      ASSERT_EQ(sentence(read), "") << type;
      EXPECT_EQ(read.value().points, two_points);
      EXPECT_EQ(cell<std::uint16_t>(read.value(), schema, 1, 0), 513);
    }
    EXPECT_EQ(read_bytes(plain_ply(big, "int"), "a.ply").value().points, (std::vector<Point>{{1, 2, -3}, {4, 5, 6}}));
    EXPECT_EQ(read_bytes(plain_ply(big, "uchar"), "a.ply").value().points, (std::vector<Point>{{1, 2, 3}, {4, 5, 6}}));
    auto reader = open_bytes(plain_ply(big, "double"), "a.ply");
    PointBatch batch;
    ASSERT_TRUE(reader.value()->seek(1).value());
    ASSERT_EQ(sentence(reader.value()->next(batch)), "");
    ASSERT_EQ(batch.points, std::vector<Point>{two_points[1]});
    EXPECT_EQ(reader.value()->place(0), "record 1");
  }
}

const std::string ascii =
    "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
    "element vertex 2\nproperty float y\nproperty list uchar int w\nproperty float x\nproperty double z\n"
    "property uchar red\nelement edge 1\nproperty int a\nend_header\n"
    "3 0 1 2\n\n2.5 2 8 9 1 -3 255\n  5 0 4 6  7 \n0\n";

TEST(PlyReader, ReadsAscii) {
  const std::vector<Attribute> schema{{"red", AttributeType::u8}};
  const auto read = read_text(ascii, "a.ply", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, two_points);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 0, 0), 255);
  auto reader = open_bytes(bytes_of(ascii), "a.ply");
  PointBatch batch;
  ASSERT_EQ(sentence(reader.value()->next(batch)), "");
  EXPECT_EQ(reader.value()->place(1), "line 17") << "as an editor counts";
}

TEST(PlyReader, ReadsVerticesWithoutZAsTwoDimensions) {
  const auto read = read_text(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float X\nproperty float Y\nend_header\n1 2\n", "a.ply");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.dimension, 2);
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2, 0}}));
}

TEST(PlyReader, RefusesEveryTruncationBeforeTheEndOfTheVertices) {
  const auto check = [](const Bytes& whole, std::size_t behind) {
    for (std::size_t size = 0; size + behind < whole.size(); ++size) {
      const auto read = read_bytes(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), "a.ply");
      ASSERT_TRUE(read.has_error()) << size;
      ASSERT_EQ(read.error().where.substr(0, 5), "a.ply");
    }
  };
  for (const bool big : {false, true}) {
    check(mixed_ply(big), 4);
    check(plain_ply(big, "float"), 0);
  }
  check(bytes_of(ascii), 5);  // up to the last number, which may be shorter
}

TEST(PlyReader, RefusesHeadersItDoesNotUnderstand) {
  const auto refusal = [](const std::string& header) { return sentence(read_text(header, "a.ply")); };
  const std::string begin = "ply\nformat ascii 1.0\n", end = "end_header\n1 2 3\n";
  EXPECT_EQ(refusal("plx\nformat ascii 1.0\n"), "a.ply, line 1: a PLY file begins with 'ply'");
  EXPECT_EQ(refusal("ply\nformat binary 1.0\n" + end), "a.ply, line 2: format 'binary' is not known");
  EXPECT_EQ(refusal("ply\nformat ascii 2.0\n" + end), "a.ply, line 2: PLY version '2.0' is not known; 1.0 is");
  EXPECT_EQ(refusal("ply\nelement vertex 1\n" + end), "a.ply: the PLY header has no format line");
  EXPECT_EQ(refusal(begin + end), "a.ply: the PLY header has no element 'vertex'");
  EXPECT_EQ(refusal(begin + "element vertex -1\n" + end), "a.ply, line 3: '-1' is not a number of elements");
  EXPECT_EQ(refusal(begin + "property float x\n" + end), "a.ply, line 3: a property stands before any element");
  EXPECT_EQ(refusal(begin + "element vertex 1\nproperty quad x\n" + end), "a.ply, line 4: type 'quad' is not known");
  EXPECT_EQ(refusal(begin + "element vertex 1\nproperty list float int x\n" + end),
            "a.ply, line 4: 'float' cannot be the type of a list's length");
  EXPECT_EQ(refusal(begin + "element vertex 1\nproperty float x\n" + end), "a.ply: the vertices have no property 'y'");
  EXPECT_EQ(refusal(begin + "nonsense\n" + end), "a.ply, line 3: 'nonsense' is not a PLY header line");
  EXPECT_EQ(refusal(begin + "element vertex 18446744073709551615\nproperty float x\nproperty float y\n" + end),
            "a.ply: the file ends within the 18446744073709551615 elements 'vertex'");
}

TEST(PlyReader, RefusesBodiesThatContradictTheHeader) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty list uchar int "
      "l\nend_header\n";
  const auto refusal = [&](const std::string& body) { return sentence(read_text(header + body, "a.ply")); };
  EXPECT_EQ(refusal("1 2 0\n"), "a.ply, line 9: the file ends after 1 of 2 vertices");
  EXPECT_EQ(refusal("1 2 0\n1\n"), "a.ply, line 9: property 'y' is missing");
  EXPECT_EQ(refusal("1 2 0\n1 abc 0\n"), "a.ply, line 9: property 'y' is 'abc', not a number");
  EXPECT_EQ(refusal("1 2 3 4\n"), "a.ply, line 8: a list has an impossible length");
  EXPECT_EQ(refusal("1 2 -1\n"), "a.ply, line 8: a list has an impossible length");
  EXPECT_EQ(refusal("1 2 nan\n"), "a.ply, line 8: a list has an impossible length");

  Bytes binary = bytes_of(
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list int double l\n"
      "element vertex 1\nproperty float x\nproperty float y\nend_header\n");
  const auto with_length = [&](std::int32_t length) {
    Bytes b = binary;
    push(b, length);
    b.resize(b.size() + 24);
    return sentence(read_bytes(b, "a.ply"));
  };
  EXPECT_EQ(with_length(2), "");
  EXPECT_EQ(with_length(-1), "a.ply: the file ends within the 1 elements 'face'");
  EXPECT_EQ(with_length(INT32_MAX), "a.ply: the file ends within the 1 elements 'face'");
}

}  // namespace
}  // namespace tessera::testing_io

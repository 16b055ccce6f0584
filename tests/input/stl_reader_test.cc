#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

const std::vector<Point> two_triangles{{0, 0, 0}, {1, 0, 0}, {0, 1.5, 0}, {1, 0, 0}, {1, 1, -3}, {0, 1.5, 0}};

// The first `n` triangles of `points`, three points each, taken again from the begin where they end.
Bytes binary(std::string head, std::uint32_t n, const std::vector<Point>& points = two_triangles) {
  head.resize(80, ' ');
  Bytes b = bytes_of(head);
  push(b, n);
  for (std::uint32_t i = 0; i < 3 * n; ++i) {
    if (i % 3 == 0)
      for (int axis = 0; axis < 3; ++axis) push(b, 0.25f);  // the normal
    for (int axis = 0; axis < 3; ++axis) push(b, static_cast<float>(points[i % points.size()][axis]));
    if (i % 3 == 2) push<std::uint16_t>(b, 0x7fff);
  }
  return b;
}

const std::string text =
    "solid a thing, facet and all\n"
    "  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n      vertex 1.0e0 0 0\n      vertex 0 1.5 0\n"
    "    endloop\n  endfacet\n"
    "  facet normal -nan nothing 0\n    outer loop\n      vertex 1 0 0\n      vertex 1 1 -3\n      vertex 0 1.5 0\n"
    "    endloop\n  endfacet\nendsolid a thing\n";

std::string refusal(const std::string& content) { return sentence(read_text(content, "a.stl")); }
std::string refusal(const Bytes& content) { return sentence(read_bytes(content, "a.stl")); }

TEST(StlReader, ReadsTheCornersOfTrianglesInTextAndBinary) {
  const auto plain = read_text(text, "a.stl");
  ASSERT_EQ(sentence(plain), "");
  EXPECT_EQ(plain.value().points, two_triangles);
  EXPECT_EQ(plain.value().info.detail, "STL, text");
  const auto packed = read_bytes(binary("made by hand", 2), "a.stl");
  ASSERT_EQ(sentence(packed), "");
  EXPECT_EQ(packed.value().points, two_triangles);
  EXPECT_EQ(packed.value().info.points, 6u);
  EXPECT_EQ(packed.value().info.detail, "STL, binary, float");
}

TEST(StlReader, TellsBinaryFromTextByTheSize) {
  const auto read = read_bytes(binary("solid name, as some programs write it", 2), "a.stl");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, two_triangles);
  EXPECT_EQ(read.value().info.detail, "STL, binary, float");
}

TEST(StlReader, IsKnownByItsContentWhateverItsName) {
  for (const char* name : {"a.stl", "a.xyz", "a.ply", "", "a"}) {
    EXPECT_EQ(read_text(text, name).value().info.format, "stl") << name;
    EXPECT_EQ(read_bytes(binary("\x01\x02", 2), name).value().info.format, "stl") << name;
  }
  EXPECT_EQ(read_text("solid y z\n1 2 3\n4 5 6\n", "a.csv").value().info.format, "xyz") << "a header";
}

TEST(StlReader, ReadsTextOfManySolidsInAnyLinesAndCase) {
  const auto read = read_text(
      "Solid\nFACET NORMAL 0 0 1 OUTER LOOP VERTEX 0 0\n0 vertex 1 0 0 vertex\n0 1.5 0 endloop "
      "endfacet endsolid x\n\nsolid facet\r\nendsolid\r\nsolid b\nfacet\nnormal 1\n2 3\nouter loop vertex "
      "1 0 0 vertex 1 1 -3 vertex 0 1.5 0 endloop\nendfacet\nendsolid",
      "a.stl");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, two_triangles);
}

TEST(StlReader, SeeksIntoTrianglesOfBinaryFiles) {
  auto opened = open_bytes(binary("", 2), "a.stl");
  auto& reader = *opened.value();
  PointBatch batch;
  for (std::size_t from = 0; from <= 6; ++from) {
    for (std::size_t most = 1; most <= 6; ++most) {
      ASSERT_TRUE(reader.seek(from).value());
      ASSERT_EQ(sentence(reader.next(batch, most)), "");
      const auto to = std::min<std::size_t>(6, from + most);
      ASSERT_EQ(batch.points, (std::vector<Point>(two_triangles.begin() + static_cast<std::ptrdiff_t>(from),
                                                  two_triangles.begin() + static_cast<std::ptrdiff_t>(to))))
          << from << " " << most;
      if (from < to) {
        EXPECT_EQ(reader.place(to - 1 - from), "triangle " + std::to_string((to - 1) / 3));
      }
    }
  }
}

TEST(StlReader, GivesAllPointsOfManyBatches) {
  constexpr std::uint32_t n = 50'001;  // 150,003 points: batches end within triangles
  const auto read = read_bytes(binary("", n), "a.stl");
  ASSERT_EQ(read.value().points.size(), 3 * n);
  for (std::size_t i = 0; i < 3 * n; ++i) ASSERT_EQ(read.value().points[i], two_triangles[i % 6]) << i;
}

TEST(StlReader, RefusesBinaryFilesWhoseCountLies) {
  const std::string is = "a.stl: is binary STL of ", by = " bytes by the number of triangles in its header, but has ";
  const Bytes whole = binary("solid", 2);
  for (std::size_t size = 84; size < whole.size(); ++size)
    ASSERT_EQ(refusal(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))),
              is + "184" + by + std::to_string(size));
  Bytes longer = whole;
  longer.resize(190);
  EXPECT_EQ(refusal(longer), is + "184" + by + "190");
  Bytes huge = whole;
  put<std::uint32_t>(huge, 80, UINT32_MAX);
  EXPECT_EQ(refusal(huge), is + "214748364834" + by + "184");
  EXPECT_EQ(refusal(Bytes(83)), "a.stl: is not STL: it neither begins with 'solid' nor is it binary");
  EXPECT_EQ(refusal(std::string("1 2 3\n4 5 6\n")),
            "a.stl: is not STL: it neither begins with 'solid' nor is it binary");
}

TEST(StlReader, RefusesEveryTruncationOfText) {
  ASSERT_EQ(refusal(text), "");
  const std::size_t needed = text.rfind("endsolid") + std::string("endsolid").size();
  for (std::size_t size = 0; size < needed; ++size)
    ASSERT_EQ(refusal(text.substr(0, size)).substr(0, 5), "a.stl") << size;
}

TEST(StlReader, RefusesTextThatIsNoStl) {
  const std::string begin = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n";
  const std::string end = "endloop\nendfacet\nendsolid\n";
  EXPECT_EQ(refusal(begin + end), "a.stl, line 6: 'endloop' stands where 'vertex' is expected");
  EXPECT_EQ(refusal(begin + "vertex 1 1\n" + end), "a.stl, line 7: z is 'endloop', not a number");
  EXPECT_EQ(refusal(begin + "vertex 1 1 a\n" + end), "a.stl, line 6: z is 'a', not a number");
  EXPECT_EQ(refusal(begin + "vertex 1 1 1\nvertex 2 2 2\n" + end),
            "a.stl, line 7: 'vertex' stands where 'endloop' is expected");
  EXPECT_EQ(refusal(begin + "vertex 1 1 1 1\n" + end), "a.stl, line 6: '1' stands where 'endloop' is expected");
  EXPECT_EQ(refusal(begin + "vertex 1 1 1\nendloop\nendfacet\n"), "a.stl, line 9: the file ends within a solid");
  EXPECT_EQ(refusal(begin + "vertex 1 1 1\n" + end + "facet\n"),
            "a.stl, line 10: 'facet' stands where 'solid' is expected");
  EXPECT_EQ(refusal(std::string("solid a\nvertex 1 2 3\n")),
            "a.stl, line 2: 'vertex' stands where 'facet' or 'endsolid' is expected");
}

TEST(StlReader, PassesNumbersThatAreNotFiniteOnWithTheirPlace) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<Point> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {std::nan(""), 0, inf}, {0, 1, 0}};
  auto reader = open_bytes(binary("", 2, points), "a.stl");
  PointBatch batch;
  ASSERT_EQ(sentence(reader.value()->next(batch)), "");
  EXPECT_TRUE(std::isnan(batch.points[4].x) && std::isinf(batch.points[4].z));
  EXPECT_EQ(reader.value()->place(4), "triangle 1");
}

}  // namespace
}  // namespace tessera::testing_io

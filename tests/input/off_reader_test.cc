#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

const std::vector<Point> corners{{0, 0, 0.5}, {1, -2.5, 0}, {1e300, 0, 0}};
const std::string lines = "0 0 0.5\n1 -2.5 0\n1e300 0 0\n";
const std::string faces = "3 0 1 2\n";

std::string refusal(const std::string& text) { return sentence(read_text(text, "a.off")); }

TEST(OffReader, ReadsCountsOnTheFirstOrSecondLineBetweenCommentsAndBlankLines) {
  for (const std::string& header :
       {std::string("OFF\n3 1 0\n"), std::string("OFF 3 1 0\n"), std::string("OFF\r\n3 1\r\n"),
        std::string("\xEF\xBB\xBFOFF\n3 1 0\n"),
        std::string("# made by hand\n\nOFF # of a\n\n  # b\n 3\t1 0 # counts\n\n"), std::string("3 1 0\n")}) {
    const auto read = read_text(header + "0 0 0.5 # one\n\n1 -2.5 0\n# two\n1e300 0 0\n" + faces, "a.off");
    ASSERT_EQ(sentence(read), "") << header;
    EXPECT_EQ(read.value().points, corners);
    EXPECT_EQ(read.value().info.points, 3u);
    EXPECT_EQ(read.value().info.format, "off");
    EXPECT_NE(read.value().info.detail.find("OFF"), std::string::npos);
    EXPECT_TRUE(read.value().info.attributes.empty());
  }
}

TEST(OffReader, IsKnownByItsFirstWordWhateverItsName) {
  for (const char* name : {"a.off", "a.xyz", "a.las", "", "a"}) {
    EXPECT_EQ(read_text("OFF\n3 1 0\n" + lines + faces, name).value().info.format, "off") << name;
    EXPECT_EQ(read_text("# A cube\nCOFF\n0 0 0\n", name).value().info.format, "off") << name;
  }
  EXPECT_EQ(read_text("OFFSET 1 2\n3 4 5\n", "a.txt").value().info.format, "xyz");
  EXPECT_EQ(refusal("1.5 2 3\n4 5 6\n"), "a.off, line 1: '1.5' is not a number of vertices, faces or edges");
  EXPECT_EQ(refusal("off\n1 0 0\n1 2 3\n"),
            "a.off, line 1: begins with 'off', but an OFF file begins with OFF, COFF, NOFF or STOFF");
}

TEST(OffReader, NormalsColoursAndTextureCoordinatesBecomeAttributes) {
  const auto names_of = [](const Contents& contents) {
    std::string names;
    for (const auto& attribute : contents.info.attributes) names += attribute.name + " ";
    return names;
  };
  const auto read = [&](const std::string& text) { return read_text(text, "a.off").value(); };
  EXPECT_EQ(names_of(read("COFF\n1 0 0\n1 2 3 255 128 0 255\n")), "red green blue alpha ");
  EXPECT_EQ(names_of(read("COFF\n1 0 0\n1 2 3 .5 1 0\n")), "red green blue ");
  EXPECT_EQ(names_of(read("NOFF\n1 0 0\n1 2 3 0 0 1\n")), "nx ny nz ");
  EXPECT_EQ(names_of(read("STOFF\n1 0 0\n1 2 3 .25 .75\n")), "s t ");
  const std::vector<Attribute> schema{
      {"t", AttributeType::f32}, {"red", AttributeType::u8}, {"nz", AttributeType::f64}};
  const auto all = read_text("STCNOFF\n2 0 0\n1 2 3 0 0 -1 7 8 9 .25 .75\n4 5 6 0 0 1 255 0 0 0 1\n", "a.off", schema);
  ASSERT_EQ(sentence(all), "");
  EXPECT_EQ(names_of(all.value()), "nx ny nz red green blue s t ");
  EXPECT_EQ(all.value().points, (std::vector<Point>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(cell<float>(all.value(), schema, 0, 0), 0.75f);
  EXPECT_EQ(cell<std::uint8_t>(all.value(), schema, 1, 1), 255);
  EXPECT_EQ(cell<double>(all.value(), schema, 0, 2), -1.0);
}

TEST(OffReader, RefusesKindsItDoesNotRead) {
  EXPECT_EQ(refusal("nOFF\n4\n1 0 0\n1 2 3 4\n"), "a.off, line 1: nOFF, with points of any dimension, is not read");
  EXPECT_EQ(refusal("C4nOFF 4\n1 0 0\n"), "a.off, line 1: nOFF, with points of any dimension, is not read");
  EXPECT_EQ(refusal("4OFF\n1 0 0\n1 2 3 1\n"), "a.off, line 1: 4OFF, with homogeneous coordinates, is not read");
  EXPECT_EQ(sentence(read_bytes(bytes_of(std::string("OFF BINARY\n\0\0\0\1\0\0\0\0\0\0\0\0", 23)), "a.off")),
            "a.off, line 1: binary OFF is not read; save it as text");
}

TEST(OffReader, RefusesHeadersThatLieOrCannotBeUnderstood) {
  EXPECT_EQ(refusal("OFF\n"), "a.off: ends within the OFF header");
  EXPECT_EQ(refusal("# nothing\n"), "a.off: ends within the OFF header");
  EXPECT_EQ(refusal("OFF\n-3 0 0\n"), "a.off, line 2: '-3' is not a number of vertices, faces or edges");
  EXPECT_EQ(refusal("OFF\n99999999999999999999 0 0\n"),
            "a.off, line 2: '99999999999999999999' is not a number of vertices, faces or edges");
  EXPECT_EQ(refusal("OFF\n3 1 0 0 0 0\n"),
            "a.off, line 2: has 6 words where the numbers of vertices, faces and edges are expected");
  EXPECT_EQ(refusal("OFF 18446744073709551615 0 0\n1 2 3\n"),
            "a.off, line 1: promises 18446744073709551615 vertices, more than the file can hold");
  EXPECT_EQ(refusal("OFF\n4 1 0\n" + lines + faces),
            "a.off, line 6: a vertex is a line of 3 numbers in this file, but this line has 4");
  EXPECT_EQ(refusal("OFF\n4 0 0\n" + lines), "a.off, line 6: the file ends after 3 of 4 vertices");
  EXPECT_EQ(refusal("OFF\n2 0 0\n0 0 0\n1 2 abc\n"), "a.off, line 4: z is 'abc', not a number");
  EXPECT_EQ(refusal("OFF\n2 0 0\n0 0 0 255 0 0\n1 1 1 255 0 0\n"),
            "a.off, line 3: a vertex is a line of 3 numbers in this file, but this line has 6");
  EXPECT_EQ(refusal("COFF\n2 0 0\n0 0 0 9 9 9 9\n1 1 1 9 9 9\n"),
            "a.off, line 4: a vertex is a line of 7 numbers in this file, but this line has 6");
  EXPECT_EQ(sentence(read_bytes(Bytes(300), "a.off")),
            "a.off, line 1: begins with '" + std::string(40, '?') +
                "...', but an OFF file begins with OFF, COFF, NOFF or STOFF");
}

TEST(OffReader, RefusesEveryTruncationBeforeTheFaces) {
  const std::string whole = "COFF # colours\n3 1 0\n0 0 1 9 8 7 6\n1 0 1 9 8 7 6\n0 1 1 9 8 7 66\n" + faces;
  ASSERT_EQ(refusal(whole), "");
  for (std::size_t size = 0; size + faces.size() < whole.size() + 1; ++size) {
    const auto says = refusal(whole.substr(0, size));
    ASSERT_EQ(says.substr(0, 5), "a.off") << size;
  }
}

TEST(OffReader, PassesNumbersThatAreNotFiniteOnWithTheirPlace) {
  auto reader = open_bytes(bytes_of("OFF\n2 0 0\n# a comment\n1 2 3\nnan 0 inf\n"), "a.off");
  PointBatch batch;
  ASSERT_EQ(sentence(reader.value()->next(batch)), "");
  ASSERT_EQ(batch.points.size(), 2u);
  EXPECT_TRUE(std::isnan(batch.points[1].x) && std::isinf(batch.points[1].z));
  EXPECT_EQ(reader.value()->place(1), "line 5");
  EXPECT_FALSE(reader.value()->seek(0).value());
}

}  // namespace
}  // namespace tessera::testing_io

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "src/input/text/text_columns.h"
#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

const std::vector<Point> two_points{{1, 2.5, -3}, {4, 5, 6}};

TEST(TextReader, ReadsEveryDelimiter) {
  for (const char* text : {"1 2.5 -3\n4 5 6\n", "1,2.5,-3\n4,5,6", "1;2.5;-3\r\n4;5;6\r\n", "1\t2.5\t-3\n4\t5\t6\n",
                           "  1   2.5 \t -3 \n 4\t 5 6", "1 , 2.5 , -3\n 4 ,5, 6\n", "\"1\",\"2.5\",\"-3\"\n4,5,6\n",
                           "\xEF\xBB\xBF"
                           "1 2.5 -3\n4 5 6\n",
                           "+1 +2.5 -3e0\n4 5 6"}) {
    const auto read = read_text(text, "a.xyz");
    ASSERT_EQ(sentence(read), "") << text;
    EXPECT_EQ(read.value().points, two_points) << text;
    EXPECT_EQ(read.value().info.dimension, 3);
  }
}

TEST(TextReader, SkipsCommentsAndBlankLines) {
  const auto read = read_text("# made by hand\n\n// x y z\n1 2.5 -3\n   \n#4 5 6\n  # 7\n4 5 6\n\n", "a.txt");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, two_points);
}

TEST(TextReader, FindsCoordinatesByTheNamesInTheHeader) {
  const std::vector<Attribute> schema{{"a", AttributeType::f64}, {"Intensity", AttributeType::u16}};
  const auto read =
      read_text("a, Z ,X,note,\"Intensity\",Y\n9,-3,1,hello,7,2.5\n8,6,4,\"x, y\",70000,5\n", "a.csv", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, two_points);
  EXPECT_EQ(read.value().info.attributes,
            (std::vector<Attribute>{{"a", AttributeType::f64}, {"Intensity", AttributeType::f64}}))
      << "note is no number";
  EXPECT_EQ(cell<double>(read.value(), schema, 1, 0), 8.0);
  EXPECT_EQ(cell<std::uint16_t>(read.value(), schema, 0, 1), 7);
  EXPECT_EQ(cell<std::uint16_t>(read.value(), schema, 1, 1), 65535) << "the nearest that fits";
}

TEST(TextReader, TakesLongitudeAndLatitudeForXAndY) {
  const auto read = read_text("lat,lon,population\n2.5,1,1000\n5,4,7\n", "a.csv");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.dimension, 2);
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2.5, 0}, {4, 5, 0}}));
}

TEST(TextReader, KnowsCoordinatesByTheirUsualNames) {
  for (const char* header : {"east,north,up", "Easting,Northing,Elevation", "E [m],N [m],Height [m]", "x_m,y_m,z_m",
                             "easting_ft,northing_ft,elev_ft", "x,y,alt"}) {
    const auto read = read_text(std::string(header) + "\n1,2.5,-3\n4,5,6\n", "a.csv");
    ASSERT_EQ(sentence(read), "") << header;
    EXPECT_EQ(read.value().points, two_points) << header;
    EXPECT_EQ(read.value().info.dimension, 3) << header;
    EXPECT_FALSE(read.value().info.degrees) << header;
  }
  EXPECT_EQ(read_text("up,north,east\n-3,2.5,1\n6,5,4\n", "a.csv").value().points, two_points);
  EXPECT_TRUE(read_text("lon,lat,height\n1,2.5,-3\n", "a.csv").value().info.degrees);
}

TEST(TextReader, TakesTheFirstColumnsUnderAHeaderThatNamesNoCoordinates) {
  const auto read = read_text("p q r s\n1 2.5 -3 7\n4 5 6 8\n", "a.xyz");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().points, two_points);
  EXPECT_EQ(read.value().info.attributes, (std::vector<Attribute>{{"s", AttributeType::f64}}));
}

TEST(TextReader, TakesTwoNumericColumnsAsTwoDimensions) {
  EXPECT_EQ(read_text("1 2\n3 4\n", "a.xyz").value().info.dimension, 2);
  EXPECT_EQ(read_text("1,2,north\n3,4,south\n", "a.csv").value().info.dimension, 2);
}

TEST(TextReader, GivesExtraColumnsAsAttributesAndEmptyCellsAsNan) {
  const std::vector<Attribute> schema{{"column_4", AttributeType::f64}, {"column_5", AttributeType::f64}};
  const auto read = read_text("1,2.5,-3,,7\n4,5,6,8\n", "a.csv", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_TRUE(std::isnan(cell<double>(read.value(), schema, 0, 0)));
  EXPECT_EQ(cell<double>(read.value(), schema, 0, 1), 7.0);
  EXPECT_EQ(cell<double>(read.value(), schema, 1, 0), 8.0);
  EXPECT_TRUE(std::isnan(cell<double>(read.value(), schema, 1, 1))) << "a line may be shorter";
}

TEST(TextReader, PassesNonFiniteNumbersOn) {
  const auto read = read_text("1 2 3\nnan inf -Infinity\n1e999 0 0\n", "a.xyz");
  ASSERT_EQ(sentence(read), "");
  EXPECT_TRUE(std::isnan(read.value().points[1].x));
  EXPECT_TRUE(std::isinf(read.value().points[1].y));
  EXPECT_TRUE(std::isinf(read.value().points[2].x));
}

TEST(TextReader, NamesTheLineThatIsWrong) {
  const auto refusal = [](const std::string& text) { return sentence(read_text(text, "a.xyz")); };
  EXPECT_EQ(refusal("1 2 3\n# c\n4 five 6\n"), "a.xyz, line 3: y is 'five', not a number");
  EXPECT_EQ(refusal("1 2 3\n4 5\n"), "a.xyz, line 2: z is missing: there are 2 columns");
  EXPECT_EQ(refusal("1,5;2,5;3,5\n4;5;6\n"), "a.xyz, line 1: x is '1,5', not a number");
  EXPECT_EQ(refusal("1\n2\n"), "a.xyz, line 1: has 1 column; a point needs at least 2");
  EXPECT_EQ(refusal("x y z\n1 2\n"), "a.xyz, line 2: has 2 columns, fewer than the header names");
  EXPECT_EQ(refusal("x y z\n"), "a.xyz, line 2: the file ends after its header, or the line before is not numbers");
  EXPECT_EQ(refusal("\n# nothing\n"), "a.xyz: holds no points, only blank lines and comments");
  EXPECT_EQ(refusal(std::string("1 2 3\n\0\n", 8)), "a.xyz: is not text: it holds zero bytes");
  EXPECT_EQ(refusal("1 2 3\n" + std::string((1 << 20) + 1, '7') + "\n"), "a.xyz, line 2: is longer than 1 MiB");
  EXPECT_EQ(refusal("1 2 3\n" + std::string(5 << 20, '7')), "a.xyz, line 2: is longer than 1 MiB");
}

TEST(TextReader, ReadsLinesAcrossBlocks) {
  std::string text;
  for (int i = 0; i < 400000; ++i) text += std::to_string(i) + " " + std::to_string(-i) + " 0.5\n";
  text += std::string(1 << 19, ' ') + "1 2 3";  // a long line, without an end
  const auto read = read_text(text, "a.xyz");
  ASSERT_EQ(sentence(read), "");
  ASSERT_EQ(read.value().points.size(), 400001u);
  for (int i = 0; i < 400000; ++i)
    ASSERT_EQ(read.value().points[static_cast<std::size_t>(i)], (Point{1.0 * i, -1.0 * i, 0.5}));
  EXPECT_EQ(read.value().points.back(), (Point{1, 2, 3}));
}

TEST(TextReader, KnowsTheLineOfEveryPoint) {
  auto reader = open_bytes(bytes_of("x y z\n\n1 2 3\n#\n4 5 6\n"), "a.xyz");
  PointBatch batch;
  ASSERT_EQ(sentence(reader.value()->next(batch)), "");
  EXPECT_EQ(reader.value()->place(0), "line 3");
  EXPECT_EQ(reader.value()->place(1), "line 5");
}

TEST(SplitLine, KeepsDelimitersWithinQuotes) {
  std::vector<std::string_view> fields;
  split_line("1, \"a, b\" ,\"c\"d,\"open, 5", Delimiter::comma, 9, fields);
  EXPECT_EQ(fields, (std::vector<std::string_view>{"1", "a, b", "\"c\"d", "\"open", "5"}));
  split_line(",,", Delimiter::comma, 9, fields);
  EXPECT_EQ(fields.size(), 3u);
  split_line("1,2,3,4", Delimiter::comma, 2, fields);
  EXPECT_EQ(fields, (std::vector<std::string_view>{"1", "2"}));
}

TEST(TextReader, CountsTheLinesBeforeAPartWhenAsked) {
  std::string text;
  for (int i = 0; i < 300'000; ++i) text += "1,2,3\n";
  text += "4,5,wrong\n";
  const auto sentence_of = [&](bool count_lines) {
    const auto reader = open_bytes(bytes_of(text), "a.csv", {}, {.part = 1, .count_lines = count_lines});
    return sentence(read_whole(*reader.value()));
  };
  EXPECT_EQ(sentence_of(true), "a.csv, line 300001: z is 'wrong', not a number");
  // The 174763rd line is the last that begins in the first MiB.
  EXPECT_EQ(sentence_of(false), "a.csv, line " + std::to_string(300'001 - 174'762) + ": z is 'wrong', not a number");
}

// All parts of a text, one after the other.
Contents read_parts(const std::string& text, const std::vector<Attribute>& schema) {
  Contents all;
  const auto parts = open_bytes(bytes_of(text), "a.csv").value()->info().parts;
  for (std::uint64_t part = 0; part < parts; ++part) {
    const auto reader = open_bytes(bytes_of(text), "a.csv", schema, {.part = part});
    const auto read = read_whole(*reader.value()).value();
    all.points.insert(all.points.end(), read.points.begin(), read.points.end());
    all.rows.insert(all.rows.end(), read.rows.begin(), read.rows.end());
  }
  return all;
}

TEST(TextReader, GivesInPartsWhatItGivesAsAWhole) {
  constexpr std::size_t part = 1 << 20;
  std::string many = "x,y,z,w\r\n";
  for (int i = 0; i < 90'000; ++i)
    many += std::to_string(i) + ",2,3," + std::to_string(i % 7) + (i % 5 == 0 ? "\r\n\n# no point\n" : "\r\n");
  const std::string comment = "#" + std::string(part - 10, ' ') + "\n";
  std::vector<std::string> texts{many, comment + comment + "x,y,z,w\n1,2,3,4\n" + comment + "5,6,7,8"};
  // The border of the first two parts within, before and behind the end of a line.
  for (std::size_t shift = 0; shift < 9; ++shift)
    texts.push_back("1,2,3\n4,5," + std::string(part - 16 + shift, ' ') + "6\n7,8,9\n");
  for (const std::string& text : texts) {
    for (const auto& schema : {std::vector<Attribute>{}, std::vector<Attribute>{{"w", AttributeType::f64}}}) {
      const auto whole = read_text(text, "a.csv", schema);
      ASSERT_EQ(sentence(whole), "");
      const auto parts = read_parts(text, schema);
      EXPECT_EQ(parts.points, whole.value().points);
      EXPECT_EQ(parts.rows, whole.value().rows);
      EXPECT_GE(whole.value().points.size(), 2u);
    }
  }
}

}  // namespace
}  // namespace tessera::testing_io

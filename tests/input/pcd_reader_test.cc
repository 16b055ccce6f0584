#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

std::string header(const std::string& fields, const std::string& sizes, const std::string& types,
                   const std::string& counts, std::size_t points, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " + sizes + "\nTYPE " +
         types + "\nCOUNT " + counts + "\nWIDTH " + std::to_string(points) +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + std::to_string(points) + "\nDATA " + data + "\n";
}

const std::string plain = header("x y z", "4 4 8", "F F F", "1 1 1", 2, "ascii");

std::string refusal(const std::string& text) { return sentence(read_text(text, "a.pcd")); }

// Packs bytes as LZF: references to what was there before where it repeats, at most `farthest` bytes back.
Bytes lzf(const Bytes& bytes, std::size_t farthest = 8192) {
  Bytes packed;
  std::size_t literals = 0;
  const auto flush = [&](std::size_t end) {
    while (literals > 0) {
      const std::size_t n = std::min<std::size_t>(32, literals);
      packed.push_back(static_cast<std::byte>(n - 1));
      packed.insert(packed.end(), bytes.begin() + static_cast<std::ptrdiff_t>(end - literals),
                    bytes.begin() + static_cast<std::ptrdiff_t>(end - literals + n));
      literals -= n;
    }
  };
  for (std::size_t at = 0; at < bytes.size();) {
    std::size_t best = 0, distance = 0;
    for (std::size_t back = 1; back <= std::min(at, farthest); ++back) {
      std::size_t n = 0;
      while (n < 264 && at + n < bytes.size() && bytes[at + n] == bytes[at + n - back]) ++n;
      if (n > best) best = n, distance = back;
    }
    if (best < 3) {
      ++at, ++literals;
      continue;
    }
    flush(at);
    const std::size_t length = best - 2, high = (distance - 1) >> 8;
    packed.push_back(static_cast<std::byte>((std::min<std::size_t>(length, 7) << 5) | high));
    if (length >= 7) packed.push_back(static_cast<std::byte>(length - 7));
    packed.push_back(static_cast<std::byte>((distance - 1) & 255));
    at += best;
  }
  flush(bytes.size());
  return packed;
}

struct Made {
  Bytes binary, compressed;  // the body of a file with these records, field by field for the second
};

// n points: x, y, z as floats, a packed colour, and two numbers of 16 bits with a padding between.
const std::string made_fields = "x y z rgb _ pair", made_sizes = "4 4 4 4 1 2", made_types = "F F F F U I",
                  made_counts = "1 1 1 1 3 2";
constexpr std::size_t made_bytes = 23;

Point made_point(std::size_t i) {
  return {static_cast<double>(i % 100), static_cast<double>(i / 100), std::round(10 * std::sin(double(i))) / 4};
}

Made make(std::size_t n) {
  std::vector<Bytes> columns(6);
  Made made;
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<Bytes> record(6);
    const Point p = made_point(i);
    for (int axis = 0; axis < 3; ++axis) push(record[static_cast<std::size_t>(axis)], static_cast<float>(p[axis]));
    push(record[3], static_cast<std::uint32_t>(0xff000000U | ((i % 256) << 16) | (7U << 8) | 255U));
    record[4].assign(3, std::byte{9});
    push(record[5], static_cast<std::int16_t>(-1 - static_cast<int>(i % 50)));
    push(record[5], static_cast<std::int16_t>(i % 1000));
    for (std::size_t f = 0; f < 6; ++f) {
      made.binary.insert(made.binary.end(), record[f].begin(), record[f].end());
      columns[f].insert(columns[f].end(), record[f].begin(), record[f].end());
    }
  }
  Bytes all;
  for (const auto& column : columns) all.insert(all.end(), column.begin(), column.end());
  const Bytes packed = lzf(all);
  push(made.compressed, static_cast<std::uint32_t>(packed.size()));
  push(made.compressed, static_cast<std::uint32_t>(all.size()));
  made.compressed.insert(made.compressed.end(), packed.begin(), packed.end());
  return made;
}

Bytes file(std::size_t n, const char* data, const Bytes& body) {
  Bytes bytes = bytes_of(header(made_fields, made_sizes, made_types, made_counts, n, data));
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

TEST(PcdReader, TextIsReadAsDoubles) {
  const auto read = read_text(plain + "0.1 2 3\n\n-1e300 nan 0.25\n", "a.pcd");
  ASSERT_EQ(sentence(read), "");
  ASSERT_EQ(read.value().points.size(), 2u);
  EXPECT_EQ(read.value().points[0], (Point{0.1, 2, 3}));
  EXPECT_EQ(read.value().points[1].x, -1e300);
  EXPECT_TRUE(std::isnan(read.value().points[1].y));
  EXPECT_EQ(read.value().info.format, "pcd");
  EXPECT_EQ(read.value().info.points, 2u);
  EXPECT_EQ(read.value().info.dimension, 3);
}

TEST(PcdReader, IsKnownByItsFirstLineWhateverItsName) {
  for (const char* name : {"a.pcd", "a.xyz", "", "a.las"})
    EXPECT_EQ(read_text(plain + "1 2 3\n4 5 6\n", name).value().info.format, "pcd") << name;
  const std::string bare = plain.substr(plain.find('\n') + 1);
  EXPECT_EQ(read_text(bare + "1 2 3\n4 5 6\n", "cloud").value().points.size(), 2u);
}

TEST(PcdReader, BinaryAndCompressedFilesHoldTheSamePointsAndAttributes) {
  for (const std::size_t n : {1, 3, 1000}) {
    const Made made = make(n);
    const auto binary = read_bytes(file(n, "binary", made.binary), "a.pcd");
    ASSERT_EQ(sentence(binary), "");
    const auto schema = binary.value().info.attributes;
    EXPECT_EQ(schema, (std::vector<Attribute>{{"blue", AttributeType::u8},
                                              {"green", AttributeType::u8},
                                              {"red", AttributeType::u8},
                                              {"pair_1", AttributeType::i16},
                                              {"pair_2", AttributeType::i16}}));
    const auto with_rows = read_bytes(file(n, "binary", made.binary), "a.pcd", schema).value();
    const auto compressed = read_bytes(file(n, "binary_compressed", made.compressed), "a.pcd", schema);
    ASSERT_EQ(sentence(compressed), "");
    const auto bare = read_bytes(file(n, "binary_compressed", made.compressed), "a.pcd").value();
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(with_rows.points[i], made_point(i));
      EXPECT_EQ(cell<std::uint8_t>(with_rows, schema, i, 2), i % 256);
      EXPECT_EQ(cell<std::uint8_t>(with_rows, schema, i, 0), 255);
      EXPECT_EQ(cell<std::int16_t>(with_rows, schema, i, 3), -1 - static_cast<int>(i % 50));
      EXPECT_EQ(cell<std::int16_t>(with_rows, schema, i, 4), i % 1000);
    }
    EXPECT_EQ(compressed.value().points, with_rows.points);
    EXPECT_EQ(compressed.value().rows, with_rows.rows);
    EXPECT_EQ(bare.points, with_rows.points);
  }
}

TEST(PcdReader, AColourInTextIsAWholeNumberOrTheFloatWithItsBytes) {
  const std::vector<Attribute> schema{
      {"red", AttributeType::u8}, {"green", AttributeType::u8}, {"blue", AttributeType::u8}};
  float bits;
  const std::uint32_t packed = 0x00030201;
  std::memcpy(&bits, &packed, sizeof bits);
  char text[64];
  std::snprintf(text, sizeof text, "1 2 3 %.9g\n", double(bits));
  const auto read = read_text(
      header("x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1", 2, "ascii") + "1 2 3 4278387457\n" + text, "a.pcd", schema);
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.attributes.size(), 3u);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 0, 0), 3);  // 4278387457 is 0xff030301
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 0, 1), 3);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 0, 2), 1);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 1, 0), 3);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 1, 1), 2);
  EXPECT_EQ(cell<std::uint8_t>(read.value(), schema, 1, 2), 1);
}

TEST(PcdReader, AHeaderThatMakesNoSenseIsRefusedWithItsLine) {
  EXPECT_EQ(refusal("# .PCD v0.7\nFIELDS x y\nFIELDS z\n"), "a.pcd, line 3: 'FIELDS' is there twice");
  EXPECT_EQ(refusal("# .PCD v0.7\nCOLOUR x y\n"), "a.pcd, line 2: 'COLOUR' is not a line of a PCD header");
  EXPECT_EQ(refusal("# .PCD v0.7\nFIELDS x y z\n"), "a.pcd: ends within the PCD header");
  EXPECT_EQ(refusal(header("x y z", "4 4", "F F F", "1 1 1", 1, "ascii") + "1 2 3\n"),
            "a.pcd: the header names 3 fields, but 2 sizes and 3 types");
  EXPECT_NE(refusal(header("x y z", "4 4 2", "F F F", "1 1 1", 1, "ascii") + "1 2 3\n")
                .find("field 'z' has type 'F' and size 2"),
            std::string::npos);
  EXPECT_EQ(refusal(header("x y z", "4 4 -4", "F F F", "1 1 1", 1, "ascii")),
            "a.pcd, line 4: '-4' is not a whole number");
  EXPECT_EQ(refusal(header("x y z", "4 4 4", "F F F", "1 1 1", 1, "zip")),
            "a.pcd, line 11: DATA is ascii, binary or binary_compressed");
  EXPECT_EQ(refusal(header("x z", "4 4", "F F", "1 1", 1, "ascii") + "1 2\n"),
            "a.pcd: the vertices have no property 'y'");
  EXPECT_EQ(refusal(header("x y", "4 4", "F F", "1 5000", 1, "ascii") + "1 2\n"),
            "a.pcd: a point has more than 4096 numbers");
  EXPECT_EQ(refusal("VERSION 0.7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 3\nHEIGHT 2\nPOINTS 5\nDATA ascii\n"),
            "a.pcd: POINTS is 5, but WIDTH times HEIGHT is 6");
  EXPECT_EQ(refusal(header("x y", "4 4", "F F", "1 1", 0, "ascii")), "a.pcd: holds no points");
  EXPECT_NE(refusal(header("x y", "4 4", "F F", "1 1", std::size_t{1} << 60, "binary_compressed"))
                .find("more than the file can hold"),
            std::string::npos);
}

TEST(PcdReader, AFileThatWasCutOffIsRefused) {
  EXPECT_NE(refusal(plain + "1 2 3\n").find("the file ends after 1 of 2 vertices"), std::string::npos);
  EXPECT_EQ(refusal(plain + "1 2\n4 5 6\n"), "a.pcd, line 12: property 'z' is missing");
  const Made made = make(100);
  for (std::size_t cut : {std::size_t{1}, std::size_t{500}, made.binary.size()}) {
    Bytes bytes = file(100, "binary", made.binary);
    bytes.resize(bytes.size() - cut);
    EXPECT_NE(sentence(read_bytes(bytes, "a.pcd")), "") << cut;
  }
  const Bytes whole = file(100, "binary_compressed", made.compressed);
  for (std::size_t size = whole.size() - made.compressed.size(); size < whole.size(); ++size)
    EXPECT_NE(sentence(read_bytes(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), "a.pcd")),
              "");
}

TEST(PcdReader, DamagedCompressionIsRefused) {
  const Made made = make(100);
  Bytes bytes = file(100, "binary_compressed", made.compressed);
  const std::size_t body = bytes.size() - made.compressed.size();
  put(bytes, body + 8, std::uint16_t{0xff3f});  // a reference at the very beginning
  EXPECT_NE(sentence(read_bytes(bytes, "a.pcd")).find("points before their beginning"), std::string::npos);
  bytes = file(100, "binary_compressed", made.compressed);
  put(bytes, body + 4, static_cast<std::uint32_t>(100 * made_bytes + 1));
  EXPECT_NE(sentence(read_bytes(bytes, "a.pcd")).find("100 points take 23 each"), std::string::npos);
  bytes = file(100, "binary_compressed", made.compressed);
  put(bytes, body, std::uint32_t{40});
  EXPECT_NE(sentence(read_bytes(bytes, "a.pcd")).find("damaged: they end"), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing_io

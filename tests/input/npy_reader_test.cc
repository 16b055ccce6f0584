#include <gtest/gtest.h>

#include <string>

#include "tests/input/io_testing.h"

namespace tessera::testing_io {
namespace {

Bytes npy(const std::string& literal, int version = 1) {
  Bytes bytes = bytes_of("\x93NUMPY");
  bytes.push_back(static_cast<std::byte>(version));
  bytes.push_back(std::byte{0});
  if (version == 1)
    push(bytes, static_cast<std::uint16_t>(literal.size()));
  else
    push(bytes, static_cast<std::uint32_t>(literal.size()));
  const auto text = bytes_of(literal);
  bytes.insert(bytes.end(), text.begin(), text.end());
  return bytes;
}

std::string literal(const std::string& type, const std::string& shape) {
  return "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }      \n";
}

template <class T>
Bytes with_numbers(Bytes bytes, std::initializer_list<double> numbers, bool swapped = false) {
  for (const double v : numbers) push(bytes, static_cast<T>(v), swapped);
  return bytes;
}

TEST(NpyReader, ReadsFloatsAndDoublesOfBothByteOrdersAndAllVersions) {
  for (const int version : {1, 2, 3}) {
    const std::vector<Point> expected{{1, 2.5, -3}, {4, 5, 6}};
    const auto le8 = with_numbers<double>(npy(literal("<f8", "(2, 3)"), version), {1, 2.5, -3, 4, 5, 6});
    const auto be8 = with_numbers<double>(npy(literal(">f8", "(2, 3)"), version), {1, 2.5, -3, 4, 5, 6}, true);
    const auto le4 = with_numbers<float>(npy(literal("<f4", "(2, 3)"), version), {1, 2.5, -3, 4, 5, 6});
    const auto be4 = with_numbers<float>(npy(literal(">f4", "(2L, 3L)"), version), {1, 2.5, -3, 4, 5, 6}, true);
    for (const auto& bytes : {le8, be8, le4, be4}) {
      const auto read = read_bytes(bytes, "a.npy");
      ASSERT_EQ(sentence(read), "");
      EXPECT_EQ(read.value().points, expected);
    }
  }
}

TEST(NpyReader, ReadsTwoColumnsAsTwoDimensions) {
  const auto read = read_bytes(with_numbers<double>(npy(literal("<f8", "(2, 2)")), {1, 2, 3, 4}), "a.npy");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.dimension, 2);
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2, 0}, {3, 4, 0}}));
}

TEST(NpyReader, ReadsFurtherColumnsAsAttributesOfTheSameType) {
  const auto bytes = with_numbers<float>(npy(literal("<f4", "(2, 5)")), {1, 2, 3, 40, 50, 4, 5, 6, 70, 80});
  const auto read = read_bytes(bytes, "a.npy", {{"column_5", AttributeType::u16}, {"absent", AttributeType::u8}});
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.detail, "NumPy <f4, n x 5");
  EXPECT_EQ(read.value().info.attributes,
            (std::vector<Attribute>{{"column_4", AttributeType::f32}, {"column_5", AttributeType::f32}}));
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1, 2, 3}, {4, 5, 6}}));
  Bytes rows;
  for (const std::uint16_t value : {50, 80}) push(rows, value), push(rows, std::uint8_t{0});
  EXPECT_EQ(read.value().rows, rows);
}

std::string structured(const std::string& columns, const std::string& shape = "(2,)") {
  return "{'descr': [" + columns + "], 'fortran_order': False, 'shape': " + shape + ", }  \n";
}

TEST(NpyReader, FindsNamedColumnsAndTakesTheOthersForAttributes) {
  auto bytes =
      npy(structured("('class', '|u1'), ('', '|V3'), ('Z', '>f4'), ('y', '<i4'), ('x', '<f8'), "
                     "(\"it's\", '>i8'), ('id', '|b1')"));
  for (int row = 0; row < 2; ++row) {
    push(bytes, static_cast<std::uint8_t>(2 + row));
    for (int i = 0; i < 3; ++i) push(bytes, std::uint8_t{77});
    push(bytes, 0.5F + static_cast<float>(row), true);
    push(bytes, std::int32_t{-7} - row);
    push(bytes, 1.25 + row);
    push(bytes, std::int64_t{1} << 60, true);
    push(bytes, std::uint8_t{1});
  }
  const auto read = read_bytes(bytes, "a.npy", {{"it's", AttributeType::i64}, {"class", AttributeType::u8}});
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.detail, "NumPy, 6 named columns");
  EXPECT_EQ(read.value().info.dimension, 3);
  EXPECT_EQ(read.value().info.attributes,
            (std::vector<Attribute>{
                {"class", AttributeType::u8}, {"it's", AttributeType::i64}, {"id_2", AttributeType::u8}}));
  EXPECT_EQ(read.value().points, (std::vector<Point>{{1.25, -7, 0.5}, {2.25, -8, 1.5}}));
  Bytes rows;
  for (int row = 0; row < 2; ++row) push(rows, std::int64_t{1} << 60), push(rows, static_cast<std::uint8_t>(2 + row));
  EXPECT_EQ(read.value().rows, rows);
}

TEST(NpyReader, WithoutAColumnZTheDimensionIsTwo) {
  const auto read =
      read_bytes(with_numbers<double>(npy(structured("('y', '<f8'), ('x', '<f8')")), {1, 2, 3, 4}), "a.npy");
  ASSERT_EQ(sentence(read), "");
  EXPECT_EQ(read.value().info.dimension, 2);
  EXPECT_EQ(read.value().points, (std::vector<Point>{{2, 1, 0}, {4, 3, 0}}));
}

TEST(NpyReader, RefusesColumnsThatAreNoNumbersAndNamesThem) {
  const auto refusal = [](const std::string& text) { return sentence(read_bytes(npy(text), "a.npy")); };
  const std::string xy = "('x', '<f8'), ('y', '<f8'), ";
  EXPECT_EQ(refusal(structured(xy + "('colour', '|u1', (3,))")),
            "a.npy: the column 'colour' has several numbers in a row; single integers, floats and doubles are read");
  EXPECT_EQ(refusal(structured(xy + "('p', [('q', '<f8'), ('r', [('s', '<f8')])])")),
            "a.npy: the column 'p' has several numbers in a row; single integers, floats and doubles are read");
  EXPECT_EQ(refusal(structured(xy + "('when', '<M8[ns]')")),
            "a.npy: the column 'when' has type '<M8[ns]'; single integers, floats and doubles are read");
  EXPECT_EQ(refusal(structured("('x', '<f8'), ('z', '<f8')")), "a.npy: has no column 'y'");
  EXPECT_EQ(refusal(structured("")), "a.npy: has no column 'x'");
  EXPECT_EQ(
      refusal(structured("('x', '<f8'), ('y', '<i8')")),
      "a.npy: the column 'y' has integers of 64 bits, which doubles would round; save it as f8, or as integers of "
      "32 bits");
  EXPECT_EQ(refusal(structured(xy, "(2, 1)")),
            "a.npy: has shape (2, 1); an array with named columns must have one dimension, the number of points");
  EXPECT_EQ(refusal(structured(xy + "('', '|V4294967295')")), "a.npy: has rows of more than 1048576 bytes");
  for (const char* columns : {"(('title', 'x'), '<f8')", "('x'", "('x', '<f8', ", "('x', '<f8', (2,)", "('x', [('y'"})
    EXPECT_EQ(refusal(structured(columns)), "a.npy: the NumPy header cannot be understood") << columns;
}

TEST(NpyReader, RefusesOtherArraysAndSaysWhatTheyAre) {
  const auto refusal = [](const std::string& text) { return sentence(read_bytes(npy(text), "a.npy")); };
  EXPECT_EQ(refusal(literal("<i4", "(2, 3)")),
            "a.npy: holds type '<i4'; arrays of f4 or f8, and of named columns, are read");
  for (const std::string shape : {"(2, 1)", "(2, 4097)", "(2, 18446744073709551615)", "(6)", "()"})
    EXPECT_NE(refusal(literal("<f8", shape)).find("; shapes from n x 2 to n x 4096 are read"), std::string::npos)
        << shape;
  EXPECT_EQ(refusal(literal("<f8", "()")).find("a.npy: has shape ();"), 0u);
  EXPECT_EQ(refusal("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }"),
            "a.npy: is in Fortran order; save numpy.ascontiguousarray(a) instead");
  for (const char* text : {"   ", "{  ", "{}  ", "nonsense", "{'descr': '<f8'}", "{'shape': (1, ", "{'descr': [[[",
                           "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999999, 3), }"})
    EXPECT_EQ(refusal(text), "a.npy: the NumPy header cannot be understood") << text;
}

TEST(NpyReader, RefusesMoreRowsThanTheFileHolds) {
  const auto few = with_numbers<double>(npy(literal("<f8", "(2, 3)")), {1, 2, 3, 4, 5});
  EXPECT_EQ(sentence(read_bytes(few, "a.npy")),
            "a.npy, record 1: the file ends before or within this record, but its header promises 2 records");
  const auto absurd = npy(literal("<f8", "(18446744073709551615, 3)"));
  EXPECT_NE(sentence(read_bytes(absurd, "a.npy")), "");
}

TEST(NpyReader, RefusesEveryTruncation) {
  const auto whole = with_numbers<double>(npy(literal("<f8", "(2, 3)")), {1, 2, 3, 4, 5, 6});
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(sentence(read_bytes(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), "a.npy")),
              "")
        << size;
}

}  // namespace
}  // namespace tessera::testing_io

#include <gtest/gtest.h>

#include <string>

#include "tests/io/io_testing.h"

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

TEST(NpyReader, RefusesOtherArraysAndSaysWhatTheyAre) {
  const auto refusal = [](const std::string& text) { return sentence(read_bytes(npy(text), "a.npy")); };
  EXPECT_EQ(refusal(literal("<i4", "(2, 3)")), "a.npy: holds type '<i4'; arrays of f4 or f8 are read");
  EXPECT_EQ(refusal("{'descr': [('x', '<f8'), ('y', '<f8', (2,))], 'fortran_order': False, 'shape': (2,), }"),
            "a.npy: holds a structured type; arrays of f4 or f8 are read");
  EXPECT_EQ(refusal(literal("<f8", "(2, 4)")), "a.npy: has shape (2, 4); n x 2 or n x 3 is read");
  EXPECT_EQ(refusal(literal("<f8", "()")), "a.npy: has shape (); n x 2 or n x 3 is read");
  EXPECT_EQ(refusal("{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }"),
            "a.npy: is in Fortran order; save numpy.ascontiguousarray(a) instead");
  for (const char* text : {"   ", "{  ", "{}  ", "nonsense", "{'descr': '<f8'}", "{'shape': (1, ", "{'descr': [[[",
                           "{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999999, 3), }"})
    EXPECT_EQ(refusal(text), "a.npy: the NumPy header cannot be understood") << text;
}

TEST(NpyReader, RefusesMoreRowsThanTheFileHolds) {
  const auto few = with_numbers<double>(npy(literal("<f8", "(2, 3)")), {1, 2, 3, 4, 5});
  EXPECT_EQ(sentence(read_bytes(few, "a.npy")),
            "a.npy, record 1: the file ends before or within it, but its header promises 2 records");
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

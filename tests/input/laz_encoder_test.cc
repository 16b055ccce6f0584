// The LAZ encoder: random chunks of every point format come back from the decoder bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "src/base/files/output_file.h"
#include "src/input/bytes/fields.h"
#include "src/input/las/las_header.h"
#include "src/input/las_copy/chunk_encoder.h"
#include "src/input/las_copy/laz_body.h"
#include "src/input/laz/chunk_decoder.h"
#include "tests/input/las_file.h"
#include "tests/input/laz_testing.h"

namespace tessera::testing_io {
namespace {

// The fields of a record that the encoder treats in ways of their own.
struct Places {
  explicit Places(int format)
      : time(format >= 6                  ? 22
             : format == 1 || format == 3 ? 20
                                          : 0),
        colour(format >= 7   ? 30
               : format == 3 ? 28
               : format == 2 ? 20
                             : 0),
        first_extra(standard_record_bytes(format)) {}
  std::size_t time, colour, first_extra;  // 0: there is none
};

// Records that change a little, with rare leaps of every field to any value.
Bytes random_records(int format, std::size_t record_bytes, std::size_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto one_in = [&](std::uint64_t k) { return random() % k == 0; };
  const Places places(format);
  constexpr std::array<std::int64_t, 12> steps{1000,    1000, 1000,    0,         7000,      30'000,
                                               900'000, -50,  -20'000, INT32_MAX, INT32_MIN, std::int64_t{1} << 40};
  std::array<std::int64_t, 5> lines{0, 0x4100000000000000, -1, INT64_MIN, INT64_MAX};
  std::size_t line = 1;
  Bytes records(n * record_bytes);
  for (std::size_t i = 0; i < n; ++i) {
    std::byte* r = records.data() + i * record_bytes;
    if (i > 0) std::copy_n(r - record_bytes, record_bytes, r);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto step = static_cast<std::uint32_t>(random() >> (one_in(50) ? 32 : 56));
      auto value = load<std::uint32_t>(r + 4 * axis) + step - (one_in(2) ? 2 * step : 0);
      if (one_in(100)) value = one_in(2) ? 0x80000000u : 0x7FFFFFFFu;
      std::memcpy(r + 4 * axis, &value, sizeof value);
    }
    for (std::size_t at = 12; at < record_bytes; ++at)
      if (one_in(6)) r[at] = static_cast<std::byte>(random() >> (one_in(2) ? 56 : 61));
    if (places.colour != 0 && one_in(4)) {  // grey
      std::copy_n(r + places.colour, 2, r + places.colour + 2);
      std::copy_n(r + places.colour, 2, r + places.colour + 4);
    }
    if (places.time == 0) continue;
    if (one_in(30)) line = random() % lines.size();
    if (one_in(200)) lines[line] = static_cast<std::int64_t>(random());
    lines[line] = static_cast<std::int64_t>(static_cast<std::uint64_t>(lines[line]) +
                                            static_cast<std::uint64_t>(steps[random() % steps.size()]));
    std::memcpy(r + places.time, &lines[line], sizeof lines[line]);
  }
  return records;
}

Bytes decoded(const Bytes& chunk, const laz::LazLayout& layout, std::size_t record_bytes, std::size_t n) {
  const auto source = memory_source("chunk", chunk);
  const laz::WantedFields plan{.record_bytes = record_bytes, .wanted = std::vector<bool>(record_bytes, true)};
  const auto decoder = laz::make_chunk_decoder(*source, layout, plan, {0, chunk.size(), 0, n});
  Bytes records(n * record_bytes);
  EXPECT_EQ(sentence(decoder->decode(n, records.data())), "");
  EXPECT_EQ(sentence(decoder->check_end()), "");
  return records;
}

// Encodes in calls of several sizes.
Bytes encoded(const Bytes& records, const laz::LazLayout& layout, std::size_t record_bytes) {
  const auto encoder = laz::make_chunk_encoder(layout, record_bytes);
  std::span<const std::byte> left = records;
  for (std::size_t n = 1; !left.empty(); n = 3 * n + 1) {
    const std::size_t bytes = std::min(left.size(), n * record_bytes);
    encoder->encode(left.first(bytes));
    left = left.subspan(bytes);
  }
  return encoder->finish();
}

void expect_equal(const Bytes& read, const Bytes& written, std::size_t record_bytes) {
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i)
    ASSERT_EQ(read[i], written[i]) << "record " << i / record_bytes << " byte " << i % record_bytes;
}

class EveryFormat : public testing::TestWithParam<std::tuple<int, std::uint16_t>> {
 protected:
  int format() const { return std::get<0>(GetParam()); }
  std::uint16_t record_bytes() const {
    return static_cast<std::uint16_t>(standard_record_bytes(format()) + std::get<1>(GetParam()));
  }
};

TEST_P(EveryFormat, GivesBackRandomRecords) {
  for (const std::uint16_t version : {3, 4}) {
    auto layout = laz::standard_layout(format(), record_bytes(), 50'000);
    if (format() >= 6)
      for (auto& item : layout.items) item.version = version;
    for (const std::size_t n : {1u, 2u, 3u, 4096u, 4097u, 4098u, 30'000u}) {
      const Bytes records = random_records(format(), record_bytes(), n, n);
      const Bytes chunk = encoded(records, layout, record_bytes());
      expect_equal(decoded(chunk, layout, record_bytes(), n), records, record_bytes());
    }
  }
}

TEST_P(EveryFormat, GivesBackRecordsOfRandomBytes) {
  std::mt19937_64 random(3);
  Bytes records(std::size_t{2000} * record_bytes());
  for (auto& byte : records) byte = static_cast<std::byte>(random());
  const auto layout = laz::standard_layout(format(), record_bytes(), 50'000);
  expect_equal(decoded(encoded(records, layout, record_bytes()), layout, record_bytes(), 2000), records,
               record_bytes());
}

TEST_P(EveryFormat, TakesLittleForEqualRecords) {
  const auto layout = laz::standard_layout(format(), record_bytes(), 50'000);
  const Bytes first = random_records(format(), record_bytes(), 1, 9);
  Bytes records;
  for (int i = 0; i < 10'000; ++i) records.insert(records.end(), first.begin(), first.end());
  const Bytes chunk = encoded(records, layout, record_bytes());
  EXPECT_LT(chunk.size(), 2500u);
  expect_equal(decoded(chunk, layout, record_bytes(), 10'000), records, record_bytes());
}

// A file of these records, in chunks of these sizes, made by hand around the body.
Bytes laz_file(const laz::LazLayout& layout, int format, const Bytes& records, std::uint16_t record_bytes,
               const std::vector<std::size_t>& chunks, unsigned threads = 1) {
  LasFile head;
  head.minor = 4;
  head.format = static_cast<std::uint8_t>(format);
  head.extra_bytes = static_cast<std::uint16_t>(record_bytes - standard_record_bytes(format));
  head.records = {{"laszip encoded", 22204, laz::laszip_payload(layout, {})}};
  Bytes begin = head.bytes();
  put(begin, 104, static_cast<std::uint8_t>(format | 0x80));
  put(begin, 247, static_cast<std::uint64_t>(records.size() / record_bytes));
  const TempFolder folder;
  auto file = OutputFile::create(folder.path() / "a.laz").value();
  EXPECT_EQ(sentence(file.append(begin)), "");
  laz::LazBody body(file, layout, record_bytes, begin.size(), threads);
  EXPECT_EQ(sentence(body.begin()), "");
  std::span<const std::byte> left = records;
  for (const std::size_t n : chunks) {
    EXPECT_EQ(sentence(body.add(left.first(n * record_bytes))), "");
    if (layout.variable_chunks()) {
      EXPECT_EQ(sentence(body.end_chunk()), "");
    }
    left = left.subspan(n * record_bytes);
  }
  EXPECT_TRUE(left.empty());
  EXPECT_EQ(sentence(body.finish()), "");
  EXPECT_EQ(sentence(file.commit()), "");
  const auto source = open_file(folder.path() / "a.laz").value();
  EXPECT_EQ(body.end(), source->size());
  Bytes bytes(source->size());
  EXPECT_EQ(sentence(source->read(0, bytes)), "");
  return bytes;
}

TEST_P(EveryFormat, GivesBackFilesOfWholeChunksAndOfOnePointMore) {
  const auto layout = laz::standard_layout(format(), record_bytes(), 100);
  for (const std::size_t n : {0u, 1u, 99u, 100u, 101u, 200u, 201u, 555u}) {
    const Bytes records = random_records(format(), record_bytes(), n, n);
    const Bytes file = laz_file(layout, format(), records, record_bytes(), {n / 3, n - n / 3});
    EXPECT_EQ(laz_file(layout, format(), records, record_bytes(), {n}, 4), file);
    const auto read = read_records(memory_source("a.laz", file), all_fields, {.threads = 3});
    ASSERT_EQ(sentence(read), "");
    expect_equal(read.value().bytes, records, record_bytes());
  }
}

TEST_P(EveryFormat, GivesBackFilesOfChunksOfAnySize) {
  const auto layout = laz::standard_layout(format(), record_bytes(), std::numeric_limits<std::uint32_t>::max());
  const std::vector<std::size_t> sizes{1, 200, 3, 70, 70, 1, 1000, 2};
  const Bytes records = random_records(format(), record_bytes(), 1347, 1);
  const Bytes file = laz_file(layout, format(), records, record_bytes(), sizes);
  EXPECT_EQ(laz_file(layout, format(), records, record_bytes(), sizes, 3), file);
  const auto read = read_records(memory_source("a.laz", file), all_fields);
  ASSERT_EQ(sentence(read), "");
  expect_equal(read.value().bytes, records, record_bytes());
}

// The records of such a chunk do not wait until it ends.
TEST(LazEncoder, GivesBackAChunkOfManyBytes) {
  constexpr std::uint16_t record_bytes = 1020;
  constexpr std::size_t n = 40'000;
  Bytes records(n * record_bytes);
  for (std::size_t i = 0; i < n; ++i) put(records, i * record_bytes + 4, static_cast<std::uint32_t>(i * i));
  const auto layout = laz::standard_layout(0, record_bytes, 50'000);
  const Bytes file = laz_file(layout, 0, records, record_bytes, {1, 30'000, n - 30'001}, 2);
  const auto read = read_records(memory_source("a.laz", file), all_fields);
  ASSERT_EQ(sentence(read), "");
  expect_equal(read.value().bytes, records, record_bytes);
}

INSTANTIATE_TEST_SUITE_P(LazEncoder, EveryFormat,
                         testing::Combine(testing::Values(0, 1, 2, 3, 6, 7, 8), testing::Values(0, 5)),
                         [](const auto& info) {
                           return "Format" + std::to_string(std::get<0>(info.param)) + "With" +
                                  std::to_string(std::get<1>(info.param)) + "ExtraBytes";
                         });

}  // namespace
}  // namespace tessera::testing_io

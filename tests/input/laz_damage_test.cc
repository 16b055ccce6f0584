// LAZ files cut off, with wrong bits, and with absurd claims: a sentence or points, and in no time.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/read_stranger.h"
#include "tests/input/laz_testing.h"
#include "tests/input/real_clouds.h"

namespace tessera::testing_io {
namespace {

// 200 points of formats 1 and 3, not chunked; a chunk of 256 of formats 6 and 7; the former as COPC.
const std::filesystem::path small = TESSERA_TEST_DATA "/../fuzz/corpus/laz";
const std::vector<std::string> small_files{"lone_star.laz", "autzen_trim.laz", "pdrf6-1.4.laz", "pdrf7-v4-1.4.laz",
                                           "small.copc.laz"};

class SmallLaz : public testing::TestWithParam<std::string> {};

TEST_P(SmallLaz, IsRead) {
  const auto read = read_bytes(file_bytes(small / GetParam()), "a.laz");
  ASSERT_EQ(sentence(read), "");
  EXPECT_GE(read.value().points.size(), 200u);
}

TEST_P(SmallLaz, CutOffAnywhereIsAnErrorOrTheSamePoints) {
  const auto whole = file_bytes(small / GetParam());
  const auto expected = read_bytes(whole, "a.laz").value().points;
  std::size_t refused = 0;
  for (std::size_t size = 0; size < whole.size(); size += size < 700 ? 1 : 7) {
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    const auto read = read_bytes(part, "a.laz", {{"intensity", AttributeType::u16}, {"gps_time", AttributeType::f64}});
    if (read.has_error()) {
      EXPECT_EQ(read.error().code, Errc::bad_input);
      EXPECT_EQ(read.error().where.substr(0, 5), "a.laz");
      ++refused;
    } else {
      EXPECT_EQ(read.value().points, expected);
    }
  }
  EXPECT_GT(refused, 100u);
}

// read_stranger holds the reader to all it promises.
TEST_P(SmallLaz, WithWrongBitsIsAnErrorOrAsManyPointsAsItSays) {
  const auto whole = file_bytes(small / GetParam());
  std::mt19937_64 random(11);
  for (int trial = 0; trial < 3000; ++trial) {
    auto bytes = whole;
    for (std::uint64_t flips = 1 + random() % 4; flips > 0; --flips)
      bytes[random() % bytes.size()] ^= static_cast<std::byte>(1u << random() % 8);
    const auto* raw = reinterpret_cast<const std::uint8_t*>(bytes.data());
    read_stranger(raw, bytes.size(), "stranger.laz");
    if (trial % 8 == 0) read_stranger(raw, bytes.size(), "stranger.laz", stranger_hints());
  }
}

INSTANTIATE_TEST_SUITE_P(Damaged, SmallLaz, testing::ValuesIn(small_files));

// The coder nearly always ends at the wrong byte when one bit among the compressed ones was wrong.
TEST(DamagedLaz, IsNearlyAlwaysNoticedThoughTheFormatHasNoChecksum) {
  for (const char* name : {"autzen_trim.laz", "ign_77050_627755.laz"}) {
    const auto whole = file_bytes(clouds / name);
    const auto expected = read_bytes(whole, name).value();
    std::mt19937_64 random(5);
    int noticed = 0, harmless = 0;
    constexpr int trials = 60;
    for (int trial = 0; trial < trials; ++trial) {
      auto bytes = whole;
      bytes[8192 + random() % (bytes.size() - 8192)] ^= static_cast<std::byte>(1u << random() % 8);
      const auto read = read_bytes(bytes, name, {}, {.threads = 2});
      noticed += read.has_error();
      if (read.has_value()) {
        EXPECT_EQ(read.value().points.size(), expected.points.size());
        harmless += read.value().points == expected.points;
      }
    }
    EXPECT_GE(noticed + harmless, trials * 8 / 10) << name;
  }
}

TEST(DamagedLaz, CutOffInTheMiddleSaysWhere) {
  auto bytes = file_bytes(clouds / "autzen_trim.laz");
  bytes.resize(bytes.size() / 2);
  EXPECT_EQ(sentence(read_bytes(bytes, "b.laz")),
            "b.laz, chunk table: would be at byte 603333 of 301676; the file was cut off, or its writer did not "
            "finish it");
}

// The writer of a file that cannot be rewritten puts the place of the table behind it.
TEST(Laz, FindsTheChunkTableThroughTheLastEightBytes) {
  auto bytes = file_bytes(small / "pdrf7-v4-1.4.laz");
  const auto expected = read_bytes(bytes, "a.laz").value().points;
  const auto points_at = load<std::uint32_t>(bytes.data() + 96);
  const auto table_at = load<std::int64_t>(bytes.data() + points_at);
  put(bytes, points_at, std::int64_t{-1});
  push(bytes, table_at);
  EXPECT_EQ(read_bytes(bytes, "a.laz").value().points, expected);
}

struct Claim {
  const char* what;
  std::size_t at;  // from the begin of the file, or of the LASzip record
  Bytes value;
  const char* part_of_sentence;
};

template <class T>
Bytes raw(T value) {
  Bytes bytes;
  push(bytes, value);
  return bytes;
}

void expect_refused(const char* file, const std::vector<Claim>& claims, bool in_record) {
  for (const auto& claim : claims) {
    auto bytes = file_bytes(small / file);
    const std::size_t begin = in_record ? load<std::uint16_t>(bytes.data() + 94) + 54u : 0;
    std::copy(claim.value.begin(), claim.value.end(), bytes.begin() + static_cast<std::ptrdiff_t>(begin + claim.at));
    const auto read = read_bytes(bytes, "a.laz");
    ASSERT_TRUE(read.has_error()) << claim.what;
    EXPECT_EQ(read.error().where.substr(0, 5), "a.laz");
    EXPECT_NE(read.error().where.find(claim.part_of_sentence), std::string::npos)
        << claim.what << ": " << read.error().where;
  }
}

TEST(Laz, RefusesWhatItsLaszipRecordMustNotSay) {
  expect_refused("lone_star.laz",
                 {{"compressor", 0, raw<std::uint16_t>(4), "names compressor 4; 0 to 3 are known"},
                  {"layers", 0, raw<std::uint16_t>(3), "compressor 3, which is not for point format 1"},
                  {"coder", 2, raw<std::uint16_t>(1), "names coder 1"},
                  {"0 points a chunk", 0, raw<std::uint64_t>(2), "chunk"},
                  {"items", 32, raw<std::uint16_t>(3), "announces 3 items"},
                  {"one item", 32, raw<std::uint16_t>(1), "lists 1 items, not the 2"},
                  {"item type", 34, raw<std::uint16_t>(10), "lists item type 10 with 20 bytes where type 6"},
                  {"item size", 36, raw<std::uint16_t>(19), "lists item type 6 with 19 bytes"},
                  {"item version", 38, raw<std::uint16_t>(3), "in version 3; 1 and 2 are read"}},
                 true);
  expect_refused("pdrf7-v4-1.4.laz",
                 {{"pointwise", 0, raw<std::uint16_t>(2), "compressor 2, which is not for point format 7"},
                  {"item version", 38, raw<std::uint16_t>(2), "in version 2; 3 and 4 are read"}},
                 true);
}

TEST(Laz, RefusesAbsurdHeaders) {
  expect_refused(
      "lone_star.laz",
      {{"4 billion points", 107, raw<std::uint32_t>(0xFFFFFFFF), "its compressed bytes end before its points do"},
       {"other format", 104, raw<std::uint8_t>(0x80), "LASzip record: lists item type 7 with 8 bytes where type 0"},
       {"extra bytes", 105, raw<std::uint16_t>(65535), "LASzip record: lists 2 items, not the 3"},
       {"waveforms", 104, raw<std::uint8_t>(0x84), "claim 28 bytes, but those of format 4 have at least 57"}},
      false);
  expect_refused(
      "pdrf7-v4-1.4.laz",
      {{"2^60 points", 247, raw<std::uint64_t>(std::uint64_t{1} << 60), "the header promises 1152921504606846976"},
       {"1 point", 247, raw<std::uint64_t>(1), "says that it has 256 points, not the 1 of the chunk table"}},
      false);
}

}  // namespace
}  // namespace tessera::testing_io

// LAZ files that LASzip wrote, against twins that it did not compress: point formats with waveforms, and points of
// several scanner channels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "src/input/las_copy/chunk_encoder.h"
#include "src/input/laz/laz_layout.h"
#include "tests/input/laz_testing.h"

namespace tessera::testing_io {
namespace {

constexpr std::size_t chunk_points = 100, extra_bytes = 3, packet_bytes = 29;

class Laszip : public testing::TestWithParam<int> {
 protected:
  static std::filesystem::path file(const std::string& ending) {
    return std::filesystem::path(TESSERA_TEST_DATA) / "laszip" / ("points_" + std::to_string(GetParam()) + ending);
  }
};

TEST_P(Laszip, RecordsAreThoseOfTheTwin) {
  const auto las = read_records(file(".las"), all_fields);
  ASSERT_EQ(sentence(las), "");
  ASSERT_EQ(las.value().size(), 300u);
  const std::size_t stride = las.value().header.record_bytes;
  for (const std::uint32_t threads : {1, 4}) {
    const auto laz = read_records(file(".laz"), all_fields, {.threads = threads});
    ASSERT_EQ(sentence(laz), "");
    ASSERT_EQ(laz.value().header.point_format, GetParam());
    ASSERT_EQ(laz.value().bytes.size(), las.value().bytes.size());
    for (std::size_t i = 0; i < laz.value().bytes.size(); ++i) {
      const std::size_t at = i % stride, record = i / stride;
      // The layer of packets is not read; the first point of a chunk is not compressed.
      const bool is_packet = at >= stride - extra_bytes - packet_bytes && at < stride - extra_bytes;
      if (GetParam() >= 9 && is_packet && record % chunk_points != 0) continue;
      ASSERT_EQ(laz.value().bytes[i], las.value().bytes[i]) << "record " << record << " byte " << at;
    }
  }
}

TEST_P(Laszip, AttributesAreThoseOfTheTwin) {
  const auto info = open_reader(file(".laz")).value()->info();
  EXPECT_EQ(info.attributes, open_reader(file(".las")).value()->info().attributes);
  const auto laz = read_path(file(".laz"), info.attributes), las = read_path(file(".las"), info.attributes);
  ASSERT_EQ(sentence(laz), "");
  EXPECT_EQ(laz.value().points, las.value().points);
  EXPECT_EQ(laz.value().rows, las.value().rows);
}

TEST_P(Laszip, DamagedChunksAreRefused) {
  auto bytes = file_bytes(file(".laz"));
  const auto points_at = load<std::uint32_t>(bytes.data() + 96);
  // Within the first stream of the first chunk.
  for (std::size_t i = 300; i < 400; ++i) bytes.at(points_at + i) = std::byte{0xA5};
  EXPECT_NE(sentence(read_bytes(bytes, "a.laz", open_reader(file(".laz")).value()->info().attributes)), "");
}

INSTANTIATE_TEST_SUITE_P(Formats, Laszip, testing::Values(4, 5, 6, 7, 8, 9, 10));

class LaszipChunks : public Laszip {};

// What Tessera writes, LASzip reads: of the same records both make the same bytes.
TEST_P(LaszipChunks, HaveTheBytesThatTheEncoderMakes) {
  const auto las = read_records(file(".las"), all_fields).value();
  const std::size_t record_bytes = las.header.record_bytes;
  auto layout = laz::standard_layout(GetParam(), static_cast<std::uint16_t>(record_bytes), chunk_points);
  for (auto& item : layout.items) item.version = 3;
  const auto bytes = file_bytes(file(".laz"));
  std::size_t at = load<std::uint32_t>(bytes.data() + 96) + 8;
  for (std::size_t first = 0; first < las.size(); first += chunk_points) {
    const auto encoder = laz::make_chunk_encoder(layout, record_bytes);
    encoder->encode(std::span(las.bytes).subspan(first * record_bytes, chunk_points * record_bytes));
    const Bytes chunk = encoder->finish();
    ASSERT_LE(at + chunk.size(), bytes.size());
    ASSERT_TRUE(std::equal(chunk.begin(), chunk.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at)))
        << "chunk of records " << first << "...";
    at += chunk.size();
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, LaszipChunks, testing::Values(6, 7, 8));

}  // namespace
}  // namespace tessera::testing_io

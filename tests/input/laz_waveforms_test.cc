// LAZ files in point formats with waveforms, against twins that LASzip did not compress.
#include <gtest/gtest.h>

#include <string>

#include "tests/input/laz_testing.h"

namespace tessera::testing_io {
namespace {

const std::filesystem::path waveforms = TESSERA_TEST_DATA "/waveforms";

class Waveforms : public testing::TestWithParam<int> {
 protected:
  static std::filesystem::path file(const char* ending) {
    return waveforms / ("waves_" + std::to_string(GetParam()) + ending);
  }
};

TEST_P(Waveforms, DoNotKeepPointsFromBeingRead) {
  const auto las = read_records(file(".las"), all_fields);
  ASSERT_EQ(sentence(las), "");
  ASSERT_EQ(las.value().size(), 300u);
  for (const std::uint32_t threads : {1, 4}) {
    const auto laz = read_records(file(".laz"), all_fields, {.threads = threads});
    ASSERT_EQ(sentence(laz), "");
    ASSERT_EQ(laz.value().header.point_format, GetParam());
    ASSERT_EQ(laz.value().bytes.size(), las.value().bytes.size());
    const std::size_t stride = las.value().header.record_bytes, extra_bytes = 3, packet = 29;
    for (std::size_t i = 0; i < laz.value().bytes.size(); ++i) {
      const std::size_t at = i % stride;
      // The layer of packets is not read.
      const bool passed_over = GetParam() > 5 && at >= stride - extra_bytes - packet && at < stride - extra_bytes;
      if (!passed_over || i < stride)
        ASSERT_EQ(laz.value().bytes[i], las.value().bytes[i]) << "record " << i / stride << " byte " << at;
    }
  }
}

TEST_P(Waveforms, GiveTheAttributesOfTheTwin) {
  const auto info = open_reader(file(".laz")).value()->info();
  EXPECT_EQ(info.attributes, open_reader(file(".las")).value()->info().attributes);
  const auto laz = read_path(file(".laz"), info.attributes), las = read_path(file(".las"), info.attributes);
  ASSERT_EQ(sentence(laz), "");
  EXPECT_EQ(laz.value().points, las.value().points);
  EXPECT_EQ(laz.value().rows, las.value().rows);
}

TEST_P(Waveforms, AreRefusedWhenAChunkIsDamaged) {
  auto bytes = file_bytes(file(".laz"));
  const auto points_at = load<std::uint32_t>(bytes.data() + 96);
  // Within the first stream of the first chunk.
  for (std::size_t i = 300; i < 400; ++i) bytes.at(points_at + i) = std::byte{0xA5};
  EXPECT_NE(sentence(read_bytes(bytes, "a.laz", open_reader(file(".laz")).value()->info().attributes)), "");
}

INSTANTIATE_TEST_SUITE_P(Formats, Waveforms, testing::Values(4, 5, 9, 10));

}  // namespace
}  // namespace tessera::testing_io

#include "src/result/store/block_sum.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace tessera::store {
namespace {

std::uint32_t zlibs(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      adler32(1, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

std::vector<std::byte> random_bytes(std::size_t n) {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(n);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

TEST(BlockChecksum, EqualsZlibsForEveryLength) {
  const auto bytes = random_bytes(65535);
  const std::vector<std::byte> largest(65535, std::byte{255});
  for (std::size_t n = 0; n <= bytes.size(); n += n < 300 || n > 65400 ? 1 : 101) {
    for (const auto* list : {&bytes, &largest}) {
      BlockChecksum sum;
      sum.add(std::span(*list).first(n));
      ASSERT_EQ(sum.value(), zlibs(std::span(*list).first(n))) << n;
    }
  }
}

TEST(BlockChecksum, OfPiecesIsThatOfTheWholeAndCopiesThem) {
  const auto bytes = random_bytes(65535);
  std::mt19937 random(2);
  for (const std::size_t longest : {1u, 40u, 3000u, 70000u}) {
    BlockChecksum sum;
    std::vector<std::byte> copy(bytes.size() + 64, std::byte{7});
    for (std::size_t at = 0; at < bytes.size();) {
      const std::size_t n = std::min<std::size_t>(random() % (longest + 1), bytes.size() - at);
      sum.copy(std::span(bytes).subspan(at, n), copy.data() + at);
      at += n;
    }
    ASSERT_EQ(sum.value(), zlibs(bytes)) << longest;
    ASSERT_TRUE(std::equal(bytes.begin(), bytes.end(), copy.begin())) << longest;
    ASSERT_EQ(copy[bytes.size()], std::byte{7}) << "nothing is written behind the end";
  }
}

TEST(BlockChecksum, StandsBigEndianInAStream) {
  BlockChecksum sum;
  sum.add(random_bytes(1000));
  std::uint32_t value = 0;
  for (const std::byte byte : sum.bytes()) value = value << 8u | static_cast<std::uint32_t>(byte);
  EXPECT_EQ(value, sum.value());
}

}  // namespace
}  // namespace tessera::store

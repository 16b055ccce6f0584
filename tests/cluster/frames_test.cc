// Frames that announce more than anybody has memory for.
#include "actors/cluster/frames.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace tessera {
namespace {

std::vector<unsigned char> header(std::uint64_t length) {
  std::vector<unsigned char> bytes(32);
  for (int i = 0; i < 4; ++i) bytes[7 - i] = static_cast<unsigned char>(length >> (8 * i));
  return bytes;
}

TEST(IncomingFrames, PassFromTheFirstToTheLastByteHoweverTheyAreCut) {
  std::vector<unsigned char> stream;
  for (const std::uint64_t length : {0U, 1U, 31U, 32U, 33U, 100'000U}) {
    const auto begin = header(length);
    stream.insert(stream.end(), begin.begin(), begin.end());
    stream.insert(stream.end(), length, 0xff);  // would be a length itself
  }
  for (const std::size_t piece : {1U, 7U, 32U, 4096U, 1'000'000U}) {
    IncomingFrames frames;
    for (std::size_t at = 0; at < stream.size(); at += piece)
      ASSERT_TRUE(frames.take(std::span(stream).subspan(at, std::min(piece, stream.size() - at)))) << piece;
    EXPECT_FALSE(frames.take(header(IncomingFrames::frame_max + 1))) << "it knows where the next one begins";
  }
}

TEST(IncomingFrames, AreRefusedWhenTheyAreTooLongAloneOrTogether) {
  IncomingFrames alone;
  EXPECT_TRUE(alone.take(header(IncomingFrames::frame_max)));
  std::vector<std::unique_ptr<IncomingFrames>> many;
  const std::size_t fit = IncomingFrames::together_max / IncomingFrames::frame_max;
  for (std::size_t i = 1; i < fit; ++i)
    EXPECT_TRUE(many.emplace_back(new IncomingFrames)->take(header(IncomingFrames::frame_max)));
  IncomingFrames late;
  EXPECT_FALSE(late.take(header(IncomingFrames::frame_max)));
  IncomingFrames short_one;
  EXPECT_TRUE(short_one.take(header(IncomingFrames::short_max)));
  many.clear();  // their connections have ended
  EXPECT_TRUE(IncomingFrames().take(header(IncomingFrames::frame_max)));
  EXPECT_FALSE(IncomingFrames().take(header(0xffff'ffff)));
}

}  // namespace
}  // namespace tessera

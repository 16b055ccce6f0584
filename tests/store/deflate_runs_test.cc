#include "src/result/store/deflate_runs.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <vector>

#include "src/result/store/packed_array.h"

namespace tessera::store {
namespace {

using Bytes = std::vector<std::byte>;

// What zlib makes of the stream; it must end where the stream does.
Bytes inflated(const Bytes& packed, std::size_t size) {
  Bytes bytes(size + 1);
  uLongf room = bytes.size();
  uLong used = packed.size();
  EXPECT_EQ(
      uncompress2(reinterpret_cast<Bytef*>(bytes.data()), &room, reinterpret_cast<const Bytef*>(packed.data()), &used),
      Z_OK);
  EXPECT_EQ(used, packed.size());
  bytes.resize(room);
  return bytes;
}

class DeflateRuns : public testing::TestWithParam<std::size_t> {
 protected:
  // Runs of `longest` elements at most, of values with the highest bit set or not.
  Bytes runs_of(std::size_t elements, std::size_t longest) {
    Bytes bytes;
    while (bytes.size() < elements * GetParam()) {
      Bytes element(GetParam());
      for (auto& byte : element) byte = static_cast<std::byte>(random_() % 3 == 0 ? random_() : 0);
      for (std::size_t n = random_() % longest + 1; n > 0; --n)
        bytes.insert(bytes.end(), element.begin(), element.end());
    }
    bytes.resize(elements * GetParam());
    return bytes;
  }
  std::mt19937 random_{3};
};
INSTANTIATE_TEST_SUITE_P(Sizes, DeflateRuns, testing::Values(1, 2, 4));

TEST_P(DeflateRuns, ZlibGivesTheBytesBackWhateverTheRuns) {
  for (const std::size_t longest : {1u, 2u, 5u, 300u, 5000u}) {
    for (std::size_t n = 0; n * GetParam() <= 65520; n += n < 20 ? 1 : 997) {
      const Bytes bytes = runs_of(n, longest);
      ASSERT_EQ(inflated(deflate_runs(bytes, GetParam()), bytes.size()), bytes) << n << " with runs to " << longest;
    }
  }
}

// Lengths about the longest match, and those that several matches share.
TEST_P(DeflateRuns, EveryLengthOfARunIsRight) {
  for (std::size_t n = 1; n < 1100; ++n) {
    Bytes bytes(GetParam() * n, std::byte{1});
    bytes.insert(bytes.end(), GetParam(), std::byte{200});
    ASSERT_EQ(inflated(deflate_runs(bytes, GetParam()), bytes.size()), bytes) << n;
  }
}

TEST_P(DeflateRuns, AreShortWhereNothingChangesAndNeverLongerThanStored) {
  EXPECT_LT(deflate_runs(Bytes(65520, std::byte{9}), GetParam()).size(), 450u);
  Bytes noise(65520);
  for (auto& byte : noise) byte = static_cast<std::byte>(random_());
  const Bytes packed = deflate_runs(noise, GetParam());
  EXPECT_EQ(packed.size(), noise.size() + plain_extra_bytes);
  EXPECT_EQ(inflated(packed, noise.size()), noise);
}

}  // namespace
}  // namespace tessera::store

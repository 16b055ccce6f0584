#include "src/store/block_sum.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>
#include <utility>
#include <vector>

namespace tessera::store {
namespace {

TEST(BlockSum, EqualsZlibsForEveryLength) {
  std::mt19937 random(1);
  std::vector<std::byte> bytes(65535);
  for (auto& byte : bytes) byte = static_cast<std::byte>(random());
  const std::vector<std::byte> largest(65535, std::byte{255});
  for (std::size_t n = 0; n <= bytes.size(); n += n < 300 || n > 65400 ? 1 : 101)
    for (const auto* list : {&std::as_const(bytes), &largest})
      ASSERT_EQ(block_sum(std::span(*list).first(n)),
                adler32(1, reinterpret_cast<const Bytef*>(list->data()), static_cast<uInt>(n)))
          << n;
}

}  // namespace
}  // namespace tessera::store

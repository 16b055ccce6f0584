#include "src/base/memory_pool.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <vector>

namespace tessera {
namespace {

// From the allocator's sizes to those of whole mappings and beyond.
TEST(MemoryPool, GrowingKeepsWhatWasWritten) {
  Mapping mapping = map_memory(100);
  std::size_t written = 0;
  for (std::size_t bytes = 100; bytes < (std::size_t{4} << 20); bytes = bytes * 3 / 2) {
    if (bytes > mapping.reserved) grow_mapping(mapping, bytes);
    ASSERT_GE(mapping.reserved, bytes);
    for (std::size_t i = 0; i < written; ++i) ASSERT_EQ(mapping.at[i], std::byte(i * 7)) << bytes;
    for (; written < bytes; ++written) mapping.at[written] = std::byte(written * 7);
  }
  shrink_mapping(mapping, 1000, written);
  for (std::size_t i = 0; i < 1000; ++i) ASSERT_EQ(mapping.at[i], std::byte(i * 7));
  unmap_memory(mapping, written);
  EXPECT_EQ(mapping.at, nullptr);
}

TEST(MemoryPool, ManySmallArraysNeedNoMappingsOfTheirOwn) {
  // A process may have 65,530.
  constexpr std::size_t n = 200'000;
  std::vector<Mapping> all(n);
  for (std::size_t i = 0; i < n; ++i) {
    all[i] = map_memory(200);
    std::memset(all[i].at, static_cast<int>(i % 251), 200);
  }
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(all[i].at[199], std::byte(i % 251));
    unmap_memory(all[i], 200);
  }
}

}  // namespace
}  // namespace tessera

#include "src/result/store/external_sort.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/store/sample_result.h"

namespace tessera {
namespace {

std::vector<std::uint64_t> sorted_by(std::size_t n, std::uint64_t memory_bytes, std::size_t* runs) {
  const test::TemporaryFolder folder;
  ExternalSort<std::uint64_t> sort(folder.path(), memory_bytes);
  std::mt19937_64 random(7);
  for (std::size_t i = 0; i < n; ++i) EXPECT_TRUE(sort.push(random() % (n / 2 + 1)));
  *runs = sort.runs();
  std::vector<std::uint64_t> result;
  EXPECT_TRUE(sort.for_each([&](std::uint64_t value) -> Status {
    result.push_back(value);
    return success();
  }));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "scratch files have no name";
  return result;
}

TEST(ExternalSort, TheAnswerDoesNotDependOnTheMemory) {
  for (const std::size_t n : {0, 1, 1024, 1025, 50000}) {
    std::size_t none = 0, some = 0;
    const auto in_memory = sorted_by(n, 1 << 24, &none);
    EXPECT_EQ(in_memory.size(), n);
    EXPECT_TRUE(std::is_sorted(in_memory.begin(), in_memory.end()));
    EXPECT_EQ(sorted_by(n, 8192, &some), in_memory);
    EXPECT_EQ(none, 0u);
    EXPECT_EQ(some > 0, n > 1024);
  }
}

TEST(ExternalSort, AFolderThatDoesNotExistIsAnIoError) {
  ExternalSort<std::uint64_t> sort("/nowhere/at/all", 8192);
  Status status = success();
  for (std::uint64_t i = 0; i < 3000 && status; ++i) status = sort.push(i);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Errc::io);
}

}  // namespace
}  // namespace tessera

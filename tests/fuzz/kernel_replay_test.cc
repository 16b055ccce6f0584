// The kernels' fuzz target, as the tests' compiler builds it: a few cases of bytes, so that the target is never found
// not to compile, and a case that failed once can be put here.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace tessera {
namespace {

// The target ends the process when the kernels differ.
TEST(KernelFuzz, KernelsAnswerAlike) {
  std::mt19937 rng(20261125);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> bytes(40 + rng() % 160);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(rng());
    EXPECT_EQ(LLVMFuzzerTestOneInput(bytes.data(), bytes.size()), 0);
  }
}

}  // namespace
}  // namespace tessera

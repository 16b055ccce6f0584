// region_cases CASES [SEED]: as many random clouds with several regions each as one likes; tells the first wrong one.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/region/region_case.h"

int main(int argc, char** argv) {
  if (argc < 2) return std::fputs("usage: region_cases CASES [SEED]\n", stderr), 2;
  const std::uint64_t cases = std::strtoull(argv[1], nullptr, 10);
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  std::uint64_t regions = 0, unread = 0;
  for (std::uint64_t seed = first; seed < first + cases; ++seed) {
    const auto wrong = tessera::testing_region::check_case(seed, regions, unread);
    if (!wrong.empty()) return std::printf("seed %llu, %s\n", static_cast<unsigned long long>(seed), wrong.c_str()), 1;
  }
  std::printf("%llu regions of %llu clouds, 0 wrong; something stayed unread for %llu\n",
              static_cast<unsigned long long>(regions), static_cast<unsigned long long>(cases),
              static_cast<unsigned long long>(unread));
  return 0;
}

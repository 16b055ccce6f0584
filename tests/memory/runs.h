// How many runs a test makes in which memory runs out, and how often in a row it does.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace tessera::testing {

// Several in a row: what says that there is no memory wants some, too.
inline constexpr std::uint64_t in_a_row[] = {1, 3, 20};

// As many as the variable MEMORY_RUNS says, else `usual`.
inline std::uint64_t runs_of(std::uint64_t usual) {
  const char* wanted = std::getenv("MEMORY_RUNS");
  return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : usual;
}

}  // namespace tessera::testing

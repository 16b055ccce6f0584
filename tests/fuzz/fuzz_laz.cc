#include "tests/fuzz/read_stranger.h"

// Whole in one thread, and as a region at half the resolution in two.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tessera::read_stranger(data, size, "stranger.laz");
  tessera::read_stranger(data, size, "stranger.laz", tessera::stranger_hints());
  return 0;
}

#include "tests/fuzz/read_stranger.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tessera::read_stranger(data, size, "stranger.fits", tessera::table_hints());
  return 0;
}

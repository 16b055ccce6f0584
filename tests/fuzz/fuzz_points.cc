#include "tests/fuzz/points/read_points.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tessera::read_stranger_points(std::as_bytes(std::span(data, size)));
  return 0;
}

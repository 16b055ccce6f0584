#include "tests/fuzz/read_stranger_ept.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tessera::read_stranger_ept(data, size);
  return 0;
}

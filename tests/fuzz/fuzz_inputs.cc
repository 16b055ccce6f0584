#include "tests/fuzz/service/ask_stranger.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  tessera::take_inputs({reinterpret_cast<const char*>(data), size});
  return 0;
}

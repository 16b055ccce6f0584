#include <spdlog/spdlog.h>

#include "tests/fuzz/service/ask_stranger.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static tessera::StrangersFront strangers;
  spdlog::set_level(spdlog::level::off);  // an audit line a request
  tessera::ask_stranger(strangers, {reinterpret_cast<const char*>(data), size});
  return 0;
}

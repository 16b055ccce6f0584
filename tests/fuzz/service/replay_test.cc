// The requests and bodies of the fuzz corpus, and all that fuzzing has found, through the service's front end in every
// build, also with sanitizers.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/fuzz/service/ask_stranger.h"

namespace tessera::service {
namespace {

TEST(AskReplay, EveryKnownRequestIsAnsweredAndEveryBodyIsTakenOrRefused) {
  StrangersFront strangers;
  int files = 0;
  for (const char* folder : {TESSERA_FUZZ_CORPUS "/request", TESSERA_FUZZ_CORPUS "/inputs"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path());
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(in), {}};
      ask_stranger(strangers, bytes);
      take_inputs(bytes);
      ++files;
    }
  }
  EXPECT_GE(files, 20);
}

}  // namespace
}  // namespace tessera::service

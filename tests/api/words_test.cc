// Sentences of the library name its own options.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "src/base/option.h"
#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cloud;
using testing::failure_of;

std::string said(const std::string& sentence) { return Failure(Cause::usage, sentence).what(); }

TEST(WordsOfTheLibrary, AreItsFunctions) {
  EXPECT_EQ(said(option("memory") + " is too small, or fewer " + option("threads")),
            "memory_bytes is too small, or fewer threads");
  EXPECT_EQ(said("try " + option("dim", "2")), "try dimension(2)");
  EXPECT_EQ(said(option("skip-invalid", "true") + ", " + option("z", "false")), "skip_invalid(true), heights(false)");
  EXPECT_EQ(said("give " + option("format", "vtu")), "give format(\"vtu\")");
  EXPECT_EQ(said(option("resume", "true") + " continues it"), "resume(true) continues it");
  EXPECT_EQ(said("a --memory.las: is empty"), "a --memory.las: is empty") << "a name is left as it is";
}

TEST(WordsOfTheLibrary, CanBeThoseOfTheProgramAroundIt) {
  const testing::TemporaryHome home;
  TriangulationOptions options;
  options.threads(2);
  options.memory_bytes(1 << 20);
  const Failure failure = failure_of([&] { triangulate(cloud("uniform", 3, 20'000), options); });
  EXPECT_EQ(std::string(failure.what()).find("memory_bytes is too small for 2 threads"), 0u) << failure.what();
  const auto own = failure.sentence([](std::string_view key, std::string_view value) {
    EXPECT_EQ(value, "");
    return "[" + std::string(key) + "]";
  });
  EXPECT_EQ(own.find("[memory] is too small for 2 threads"), 0u) << own;
  EXPECT_NE(own.find("fewer [threads]"), std::string::npos) << own;
}

TEST(WordsOfTheLibrary, SayHowSubfoldersAreRead) {
  const testing::TemporaryHome home;
  std::filesystem::create_directories(home.path() / "block" / "sub");
  std::ofstream(home.path() / "block" / "sub" / "a.xyz") << "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  TriangulationOptions options;
  options.folder(home.path() / "out");
  const std::string block = home.path() / "block";
  const Failure failure = failure_of([&] { triangulate({block}, options); });
  EXPECT_EQ(failure.cause(), Cause::io);
  EXPECT_NE(std::string(failure.what()).find("; recursive(true) looks into its subfolders, too"), std::string::npos)
      << failure.what();
  options.recursive(true);
  EXPECT_EQ(triangulate({block}, options).cells(), 1u);
}

}  // namespace
}  // namespace tessera

#include "src/base/option.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Option, IsNamedWhereTheSentenceIsShown) {
  const std::string sentence = option("memory") + " is too small; " + option("overwrite", "true") + " helps";
  EXPECT_EQ(in_plain_words(sentence), "memory is too small; overwrite=true helps");
  EXPECT_EQ(render(sentence, [](std::string_view key, std::string_view) { return "<" + std::string(key) + ">"; }),
            "<memory> is too small; <overwrite> helps");
  EXPECT_EQ(in_plain_words(option("dim") + option("dim", "2") + option("skip-invalid", "false")),
            "dimdim=2skip-invalid=false");
}

TEST(Option, KeysOfASentenceAreListedOnceInTheirOrder) {
  EXPECT_EQ(option_keys("fewer " + option("threads") + ", more " + option("memory") + "; " + option("threads", "1")),
            (std::vector<std::string>{"threads", "memory"}));
  EXPECT_TRUE(option_keys("a.las: --memory is empty").empty());
}

TEST(Option, NamesOfFilesAreNeverTakenForOne) {
  // Every byte that a path may hold, and the end of a mark without its begin.
  std::string path;
  for (int c = 1; c < 256; ++c) path += static_cast<char>(c);
  path += "memory\x01 memory --memory";
  EXPECT_EQ(in_plain_words(path + option("memory") + path), path + "memory" + path);
  EXPECT_EQ(option_keys(path + option("crop") + path), std::vector<std::string>{"crop"});
}

TEST(Option, NoNulIsLeftOfWhatIsNoMark) {
  const std::string nul(1, '\0');
  for (const std::string wrong :
       {"", "memory", "Memory\x01", "\x01", "=1\x01", "a=\x01", "a b\x01", "a=B\x01", "2d\x01"}) {
    EXPECT_EQ(in_plain_words("x" + nul + wrong + option("crop") + "y"), "x " + wrong + "cropy");
  }
  EXPECT_EQ(in_plain_words(nul + nul + option("crop") + nul), "  crop ");
}

TEST(OptionDeathTest, WhatIsNoKeyOrValueIsOurMistake) {
  EXPECT_DEATH(option("--memory"), "an option has a key");
  EXPECT_DEATH(option("memory", ""), "an option has a key and a value");
  EXPECT_DEATH(option("memory", "a b"), "an option has a key and a value");
}

}  // namespace
}  // namespace tessera

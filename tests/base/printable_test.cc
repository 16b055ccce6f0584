#include "src/base/printable.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Printable, WhatPeopleWriteStays) {
  for (const char* text : {"", "abc ~", "\xC3\xA9t\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\x98\x80", "\xC2\xA0"})
    EXPECT_EQ(printable(text), text);
  EXPECT_EQ(printable_lines("a\nb\n"), "a\nb\n");
}

TEST(Printable, NothingThatATerminalObeysAndNothingThatTurnsWritingAround) {
  EXPECT_EQ(printable("a\x1b]0;b\x07"), "a?]0;b?");
  EXPECT_EQ(printable("a\x7f"), "a?");
  EXPECT_EQ(printable("a\nb\tc\rd"), "a b c d");
  EXPECT_EQ(printable_lines("a\rb\n\x1b[2J"), "a b\n?[2J");
  EXPECT_EQ(printable("\xC2\x9B"
                      "2J"),
            "?2J")
      << "C1, which begins sequences as ESC [ does";
  EXPECT_EQ(printable("a\xC2\x85"
                      "b"),
            "a?b")
      << "the end of a line, for some";
  EXPECT_EQ(printable_lines("\xE2\x80\xA8|\xE2\x80\xA9"), "?|?") << "separators of lines and paragraphs";
  for (const char* mark :
       {"\xD8\x9C", "\xE2\x80\x8E", "\xE2\x80\x8F", "\xE2\x80\xAA", "\xE2\x80\xAE", "\xE2\x81\xA6", "\xE2\x81\xA9"})
    EXPECT_EQ(printable(std::string("a") + mark + "b"), "a?b");
  EXPECT_EQ(printable("caf\xE9 \xE2\x82"), "caf? ??") << "no UTF-8";
}

TEST(Printable, SentencesHaveTheBeginning) {
  EXPECT_EQ(in_quotes("cube"), "'cube'");
  EXPECT_EQ(in_quotes(std::string(41, 'x')), "'" + std::string(40, 'x') + "...'");
  EXPECT_EQ(in_quotes("a\nb"), "'a b'");
}

}  // namespace
}  // namespace tessera

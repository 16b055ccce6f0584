#include "src/front/apps/man_page.h"

#include <gtest/gtest.h>

namespace tessera::apps {
namespace {

TEST(Roff, NoCharacterIsAMark) {
  EXPECT_EQ(roff("a-b"), "a\\-b");
  EXPECT_EQ(roff("a\\b"), "a\\eb");
  EXPECT_EQ(roff(".TH\n'x"), "\\&.TH\n\\&\\(aqx");
  EXPECT_EQ(roff("a.b, it's"), "a.b, it\\(aqs");
}

}  // namespace
}  // namespace tessera::apps

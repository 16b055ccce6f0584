#include "src/front/apps/words.h"

#include <gtest/gtest.h>

#include "src/base/option.h"

namespace tessera::apps {
namespace {

TEST(FlagName, IsWhatIsTypedOnTheCommandLine) {
  EXPECT_EQ(render(option("memory") + " is too small", flag_name), "--memory is too small");
  EXPECT_EQ(render(option("overwrite", "true") + " replaces it", flag_name), "--overwrite replaces it");
  EXPECT_EQ(render(option("z", "false") + " leaves the heights out", flag_name), "--no-z leaves the heights out");
  EXPECT_EQ(render("try " + option("dim", "2"), flag_name), "try --dim 2");
  EXPECT_EQ(render("add " + option("format", "npy"), flag_name), "add --format npy");
}

}  // namespace
}  // namespace tessera::apps

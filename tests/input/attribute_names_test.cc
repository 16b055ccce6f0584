#include <gtest/gtest.h>

#include <set>
#include <string>

#include "src/input/bytes/fields.h"

namespace tessera {
namespace {

TEST(AttributeNames, AreUniqueAndWithoutWhatXmlAndTerminalsObey) {
  AttributeNames names;
  EXPECT_EQ(names.make("a"), "a");
  EXPECT_EQ(names.make("a_3"), "a_3");
  EXPECT_EQ(names.make("a"), "a_2");
  EXPECT_EQ(names.make("a"), "a_4");
  EXPECT_EQ(names.make("a_3"), "a_3_2");
  EXPECT_EQ(names.make("x"), "x_2") << "a name that means something";
  EXPECT_EQ(names.make("b/c\n"), "b_c_");
  EXPECT_EQ(names.make("d\xC2\x9B"
                       "e\xE2\x80\xAE"),
            "d_e_");
  EXPECT_EQ(names.make(""), "_");
}

// Trying every number from 2 on would take hours.
TEST(AttributeNames, ManyOfOneNameAreAsQuickAsOthers) {
  AttributeNames names;
  std::set<std::string> made;
  constexpr std::size_t count = 300'000;
  for (std::size_t i = 0; i < count; ++i) made.insert(names.make("a"));
  EXPECT_EQ(made.size(), count);
}

}  // namespace
}  // namespace tessera

#include "src/front/apps/help.h"

#include <gtest/gtest.h>

namespace tessera::apps {
namespace {

const std::vector<std::string> commands{"triangulate", "verify", "info", "export"};

using Words = std::vector<std::string>;

std::string refused(const Words& words) {
  const auto resolved = resolve_command(words, commands);
  return resolved ? "" : resolved.error().where;
}

TEST(NearestCommand, IsTheOneThatWasMeant) {
  for (const auto* word :
       {"tri", "triangle", "triangualte", "traingulate", "triangulates", "Triangulate", "riangulate"}) {
    EXPECT_EQ(nearest(word, commands), "triangulate") << word;
  }
  EXPECT_EQ(nearest("verfy", commands), "verify");
  EXPECT_EQ(nearest("inof", commands), "info");
  EXPECT_EQ(nearest("expor", commands), "export");
}

TEST(NearestCommand, IsNoneOfWhatIsFar) {
  for (const auto& word : Words{"", "t", "foo", "scan.las", "block/*.las", "frobnicate", std::string(100'000, 'v')}) {
    EXPECT_FALSE(nearest(word, commands)) << word;
  }
  EXPECT_FALSE(nearest("info", {}));
}

TEST(ResolveCommand, TakesHelpAsAWord) {
  EXPECT_EQ(resolve_command({"help"}, commands).value(), Words{"--help"});
  EXPECT_EQ(resolve_command({"help", "info"}, commands).value(), (Words{"info", "--help"}));
  EXPECT_EQ(resolve_command({"help", "--version"}, commands).value(), (Words{"--help", "--version"}));
  EXPECT_EQ(refused({"help", "inof"}), "'inof' is not a command; perhaps you mean 'info'; see 'tessera --help'");
}

TEST(ResolveCommand, LeavesTheRestAsItIs) {
  for (const auto& words :
       {Words{"--version"}, Words{"info", "help"}, Words{"-x", "foo"}, Words{"export", "help", "-o", "x"}}) {
    EXPECT_EQ(resolve_command(words, commands).value(), words);
  }
}

TEST(ResolveCommand, RefusesWhatIsNoCommand) {
  EXPECT_EQ(refused({}), "no command is given; see 'tessera --help'");
  EXPECT_EQ(refused({"foo", "-o", "x"}),
            "'foo' is not a command; there are triangulate, verify, info, export; see 'tessera --help'");
}

}  // namespace
}  // namespace tessera::apps

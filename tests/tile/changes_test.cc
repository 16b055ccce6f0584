// A stored result that is changed is the triangulation of what it has then, tile by tile; and each part of the rule by
// which it is changed is needed.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>

#include "tests/tile/changes.h"

namespace tessera::testing {
namespace {

// Of each test; nightly.sh runs more, with other seeds.
std::uint64_t figure(const char* name, std::uint64_t otherwise) {
  const char* wanted = std::getenv(name);
  return wanted == nullptr ? otherwise : std::stoull(wanted);
}

void expect_right(const ChangeOptions& options) {
  const ChangeReport report = change_worlds(options);
  EXPECT_EQ(report.wrong, "");
  std::cout << "figures: " << report.changes() << " changes (" << report.removals << " removals, " << report.additions
            << " additions, " << report.both << " of both), " << report.skipped << " that leave nothing, "
            << report.begun << " of " << report.tiles << " tiles began, " << report.woken << " were awake, "
            << report.lost << " were lost, " << report.sent << " points were sent\n";
  EXPECT_GT(report.removals, options.worlds / 2);
  EXPECT_GT(report.additions, options.worlds / 2);
  EXPECT_GT(report.both, options.worlds / 2);
}

TEST(Changes, GiveEveryTileTheCellsOfTheGlobalTriangulation) {
  expect_right({.seed = figure("CHANGES_SEED", 1), .worlds = figure("CHANGES_WORLDS", 1500)});
}

TEST(Changes, AreRightWhateverIsLost) {
  expect_right({.seed = figure("CHANGES_SEED", 1), .worlds = figure("CHANGES_WORLDS", 1500) / 2, .losses = true});
}

TEST(Changes, AreRightInTilesThatStayInMemory) {
  expect_right({.seed = figure("CHANGES_SEED", 1), .worlds = figure("CHANGES_WORLDS", 1500), .live = true});
}

TEST(Changes, AreRightInTilesThatStayInMemoryWhateverIsLost) {
  expect_right(
      {.seed = figure("CHANGES_SEED", 1), .worlds = figure("CHANGES_WORLDS", 1500) / 2, .losses = true, .live = true});
}

struct Part {
  const char* name;
  Mutant mutant;
  bool losses = false;
  bool live = false;
};

class ChangesWithout : public ::testing::TestWithParam<Part> {};

// So the tests above would notice it.
TEST_P(ChangesWithout, AreWrong) {
  const auto wrong = [] {
    try {
      const ChangeReport report = change_worlds({.seed = 1,
                                                 .worlds = 20'000,
                                                 .mutant = GetParam().mutant,
                                                 .losses = GetParam().losses,
                                                 .live = GetParam().live});
      return report.wrong.empty() ? "" : std::to_string(report.changes()) + " changes, then " + report.wrong;
    } catch (const std::exception& e) {  // a tile has noticed it first
      return std::string(e.what());
    }
  }();
  EXPECT_NE(wrong, "") << "all changes are right without it";
  std::cout << wrong << '\n';
}

INSTANTIATE_TEST_SUITE_P(Parts, ChangesWithout,
                         ::testing::Values(Part{"CommonPoint", Mutant::no_common},
                                           Part{"CommonPointOfTilesThatKnowOthers", Mutant::common_for_the_lonely},
                                           Part{"CommonPointThatStays", Mutant::new_common},
                                           Part{"CommonPointThatIsNotTheLeast", Mutant::least_common},
                                           Part{"FreshNeighboursOfRemovedPoints", Mutant::affected_not_fresh},
                                           Part{"BeginOfAffectedTiles", Mutant::begin_if_changed},
                                           Part{"StoredForeignVertices", Mutant::no_foreign},
                                           Part{"RemovalFromForeignVertices", Mutant::removed_foreign},
                                           Part{"IntroductionOfForeignPairs", Mutant::foreign_pairs},
                                           Part{"EdgesOfArrivalsThatAreNotFresh", Mutant::old_arrivals},
                                           Part{"IntroductionOfRefusedPoints", Mutant::refused_fresh},
                                           Part{"AnswersOfThoseWhoKnowAlready", Mutant::answers},
                                           Part{"PointsAroundFilledHoles", Mutant::untold_holes},
                                           Part{"OwnerOfAFilledHole", Mutant::shared_holes},
                                           Part{"RemovalsWhileATileSlept", Mutant::missed_removals, false, true},
                                           Part{"NewSentSets", Mutant::forgotten_sent, false, true},
                                           Part{"NewFreshPoints", Mutant::forgotten_fresh, false, true},
                                           Part{"NewRefusedPoints", Mutant::forgotten_refused, false, true},
                                           Part{"Replay", Mutant::no_replay, true},
                                           Part{"ReplayOfQuotes", Mutant::replayed_quotes, true}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace tessera::testing

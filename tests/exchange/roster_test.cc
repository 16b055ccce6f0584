#include "src/exchange/roster.h"

#include <gtest/gtest.h>

#include <vector>

#include "src/exchange/course.h"
#include "src/exchange/told_once.h"

namespace tessera {
namespace {

using Standing = Roster::Standing;
using Reached = Roster::Reached;

TEST(Roster, AsksOfThoseAloneThatAreNotGone) {
  Roster roster;
  EXPECT_TRUE(roster.nobody());
  const NodeId a = roster.add(), b = roster.add(), c = roster.add();
  EXPECT_EQ(c, NodeId{2});
  EXPECT_FALSE(roster.nobody());
  roster[a].standing = roster[b].standing = Standing::there;
  roster[a].reached = Reached::settled;
  EXPECT_FALSE(roster.all_reached(Reached::settled));
  roster[b].standing = Standing::lost;
  EXPECT_TRUE(roster.all_reached(Reached::settled)) << "c has no part yet, and so no tiles";
  EXPECT_FALSE(roster.has(b));
  EXPECT_FALSE(roster.has(NodeId{3}));
  roster.forget_reached();
  EXPECT_FALSE(roster.all_reached(Reached::settled));
  roster[a].begun = true;
  EXPECT_TRUE(roster.all_have_begun());
  EXPECT_TRUE(roster.any_has_begun());
  roster.begin_stage();
  EXPECT_FALSE(roster.all_have_begun());
  roster[a].standing = Standing::left;
  roster[c].standing = Standing::refused;
  EXPECT_TRUE(roster.nobody());
  EXPECT_FALSE(roster.all_refused());
}

TEST(Roster, KnowsWhoIsOverAndWhoIsGone) {
  Roster::Node node;
  EXPECT_FALSE(node.over() || node.there() || node.gone());
  node.standing = Standing::ended;
  EXPECT_TRUE(node.over() && !node.gone());
  for (const Standing standing : {Standing::refused, Standing::lost, Standing::left}) {
    node.standing = standing;
    EXPECT_TRUE(node.over() && node.gone());
  }
}

TEST(Roster, OpensSharesAndDoesNotBringBackANodeThatIsGone) {
  Roster roster;
  const NodeId a = roster.add(), b = roster.add();
  EXPECT_FALSE(roster.all_have_answered());
  roster[b].standing = Standing::lost;
  roster.open(a, true, {4, 100, "a"});
  roster.open(b, false, {2, 50, "b"});
  EXPECT_TRUE(roster[a].there());
  EXPECT_EQ(roster[a].reached, Reached::settled);
  EXPECT_EQ(roster[a].threads, 4u);
  EXPECT_EQ(roster[b].standing, Standing::lost);
  EXPECT_EQ(roster[b].reached, Reached::nothing);
  EXPECT_TRUE(roster.all_have_answered());
  EXPECT_EQ(roster.memory_bytes(), 150u);
  EXPECT_TRUE(roster.knows("b"));
  EXPECT_FALSE(roster.knows("c"));
  EXPECT_FALSE(roster.all_are_over());
  roster[a].standing = Standing::ended;
  EXPECT_TRUE(roster.all_are_over());
}

TEST(Roster, HasTheSharesOfAnEarlierCoordinatorThatAreFound) {
  Roster roster;
  roster.take_numbers(2);
  roster.find(NodeId{1}, true, {1, 7, ""});
  EXPECT_TRUE(roster.has(NodeId{1}));
  EXPECT_FALSE(roster.has(NodeId{0}));
  EXPECT_TRUE(roster.any_has_begun());
  EXPECT_FALSE(roster.knows("")) << "nodes without a name are not known by it";
}

TEST(Roster, LeavesNumbersToThoseThatAreNotFound) {
  Roster roster;
  roster.take_numbers(2);
  EXPECT_TRUE(roster.nobody());
  EXPECT_EQ(roster.add(), NodeId{2});
}

TEST(Roster, CountsTilesOncePerTable) {
  Placements placements({{1, 1, 1}, {TileId{0}, TileId{1}, TileId{2}}, {}},
                        {{}, 0, {NodeId{0}, NodeId{1}, NodeId{1}}, {{}, {}, {}}});
  Roster roster;
  const NodeId a = roster.add(), b = roster.add();
  roster.count_tiles(placements);
  EXPECT_EQ(roster[a].tiles, 1u);
  EXPECT_EQ(roster[b].tiles, 2u);
  roster[a].tiles = 9;
  roster.count_tiles(placements);
  EXPECT_EQ(roster[a].tiles, 9u) << "the table is the same";
  placements.change(std::vector<Placement>{{TileId{2}, a, {{}, 1}}});
  roster.count_tiles(placements);
  EXPECT_EQ(roster[a].tiles, 2u);
  EXPECT_EQ(roster[b].tiles, 1u);
}

TEST(ToldOnce, EachWordOnceUntilItIsForgotten) {
  ToldOnce said;
  EXPECT_TRUE(said.mark_told(ShareEvent::idle));
  EXPECT_FALSE(said.mark_told(ShareEvent::idle));
  EXPECT_TRUE(said.mark_told(ShareEvent::begun));
  said.forget(ShareEvent::idle);
  EXPECT_TRUE(said.mark_told(ShareEvent::idle));
  EXPECT_FALSE(said.mark_told(ShareEvent::begun));
  said.forget_all();
  EXPECT_TRUE(said.mark_told(ShareEvent::begun));
}

using At = Course::At;

TEST(Course, GoesThroughStages) {
  Course course(At::opening);
  EXPECT_FALSE(course.works());
  course.begin(false);
  EXPECT_FALSE(course.disturb()) << "nobody believed it quiet";
  course.settle();
  EXPECT_TRUE(course.disturb());
  EXPECT_TRUE(course.is(At::exchanging));
  course.settle();
  course.collect();
  course.begin_next_stage();
  EXPECT_TRUE(course.is(At::exchanging));
  course.settle();
  course.collect();
  EXPECT_TRUE(course.works());
  course.finish();
  EXPECT_TRUE(course.ends());
}

TEST(Course, OfASettledRunBeginsWithTheEnd) {
  Course course(At::finding);
  course.open();
  course.begin(true);
  EXPECT_TRUE(course.is(At::collecting));
}

TEST(Course, MakesNoStepThatDoesNotFollow) {
  Course course(At::opening);
  EXPECT_THROW(course.collect(), std::logic_error);
  EXPECT_THROW(course.finish(), std::logic_error);
  course.begin(false);
  EXPECT_THROW(course.begin(false), std::logic_error);
  EXPECT_THROW(course.collect(), std::logic_error);
  EXPECT_TRUE(course.is(At::exchanging));
  course.end();
  EXPECT_TRUE(course.ends());
}

}  // namespace
}  // namespace tessera

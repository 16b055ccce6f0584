// What is done for a node that wants to leave, at each step of a job.
#include "src/exchange/leaving.h"

#include <gtest/gtest.h>

#include <vector>

namespace tessera {
namespace {

using At = Course::At;

class LeavingNode : public ::testing::Test {
 protected:
  LeavingNode() {
    for (const NodeId node : {roster_.add(), roster_.add()}) roster_[node].standing = Roster::Standing::there;
  }
  LeaveStep next(const Course& course) { return next_leave_step(course, roster_, placements_, NodeId{1}); }

  Roster roster_;
  Placements placements_{{{1, 1}, {TileId{0}, TileId{1}}, {}}, {{}, 0, {NodeId{0}, NodeId{1}}, {{}, {}}}};
};

TEST_F(LeavingNode, HasBegunNothingBeforeTheJobBegins) {
  EXPECT_EQ(next(Course(At::opening)), LeaveStep::dismiss);
  EXPECT_EQ(next(Course(At::exchanging)), LeaveStep::hand_over);
  roster_[NodeId{1}].standing = Roster::Standing::asked;
  EXPECT_EQ(next(Course(At::exchanging)), LeaveStep::dismiss) << "its share is not open yet";
}

TEST_F(LeavingNode, IsToldOnceToHandOver) {
  const Course course(At::exchanging);
  EXPECT_EQ(next(course), LeaveStep::hand_over);
  EXPECT_TRUE(placements_.hands_over(NodeId{1}));
  EXPECT_EQ(next(course), LeaveStep::wait);
}

TEST_F(LeavingNode, StoresWhatItHasAndIsToldOnceToEnd) {
  const Course course(At::collecting);
  EXPECT_EQ(next(course), LeaveStep::wait);
  roster_[NodeId{1}].reached = Roster::Reached::collected;
  EXPECT_EQ(next(course), LeaveStep::finish);
  EXPECT_TRUE(roster_[NodeId{1}].dismissed);
  EXPECT_EQ(next(course), LeaveStep::wait);
}

TEST_F(LeavingNode, WaitsWhileTilesSettleAndAtTheEnd) {
  for (const At at : {At::settling, At::finishing, At::ending}) EXPECT_EQ(next(Course(at)), LeaveStep::wait);
}

}  // namespace
}  // namespace tessera

// That somebody else has told a tile of a point is believed of those alone who go by the same table.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/delaunay/delaunay_program.h"
#include "src/exchange/tile_life.h"
#include "tests/tile/scratch.h"

namespace tessera::testing {
namespace {

constexpr TileId self{0}, fence_owner{1}, other{2}, dead{3};
constexpr std::uint64_t point = 7, fence = 3;  // and the three after it

// A triangle of its own, in a fence of another tile's points; a third tile's point comes between.
class Words : public ::testing::Test {
 protected:
  Words() : scratch_({{{4, 4, 0}, 0}, {{5, 4, 0}, 1}, {{4, 5, 0}, 2}}, 2) {
    Bounds bounds;
    bounds.add(Point{0, 0, 0});
    bounds.add(Point{30, 10, 0});
    const std::vector<std::vector<TileId>> neighbours{{}, {}, {fence_owner}, {}};
    stage_.dimension = 2;
    stage_.boxes = std::make_shared<const std::vector<Box>>(4, Box{{1, 1, 1}, {-1, -1, -1}});
    stage_.around =
        std::make_shared<const KnownFromStart>(std::vector<Bounds>(4, bounds), neighbours, std::vector<Seed>{});
    stage_.storage = context_.storage = &scratch_;
    stage_.store = &scratch_;
    context_.programs = std::make_shared<DelaunayStage>(stage_);
    tile_ = std::make_unique<TileLife>(TileIncarnation{self, {}}, context_, first_);
    EXPECT_TRUE(tile_->begin());
    hear(fence_owner, 0,
         {of(fence_owner, 0, 0, fence), of(fence_owner, 10, 0, fence + 1), of(fence_owner, 0, 10, fence + 2),
          of(fence_owner, 10, 10, fence + 3)});
    splay();
  }

  static SharedPoint of(TileId owner, double x, double y, std::uint64_t id, std::uint32_t told = 0) {
    return {{x, y, 0}, PointId{id}, owner, told};
  }
  void hear(TileId from, std::uint32_t epoch, std::vector<SharedPoint> points) {
    const auto bytes = std::as_bytes(std::span<const SharedPoint>(points));
    EXPECT_TRUE(tile_->receive({{from, {}}, {self, {}}, {{}, epoch}, 1, {bytes.begin(), bytes.end()}}));
  }
  // Of the third tile: it has told the fence's owner.
  void hear_word(std::uint32_t epoch) {
    hear(other, epoch, {of(other, 6, 6, point, stage_.around->bit(other, fence_owner))});
  }
  std::vector<Update> splay() {
    EXPECT_TRUE(tile_->step());
    return tile_->take_outgoing();
  }
  void rejoin() {
    auto next = std::make_shared<RoutingTable>(*first_);
    next->epoch = {{}, 1};
    next->incarnations[dead.value] = {{}, 1};
    const auto rebirths = incarnation_changes_between(*first_, *next, nullptr);
    tile_->rejoin(std::move(next), rebirths.get());
  }
  // Whether the two whose points are neighbours here are introduced: one of them hears of the other's.
  static bool introduced(const std::vector<Update>& updates) {
    for (const Update& update : updates) {
      for (std::size_t at = 0; at < update.message.size(); at += sizeof(SharedPoint)) {
        SharedPoint p;
        std::memcpy(&p, update.message.data() + at, sizeof p);
        if (update.to.tile == fence_owner && p.tile == other) return true;
        if (update.to.tile == other && p.tile == fence_owner) return true;
      }
    }
    return false;
  }

 private:
  const std::shared_ptr<const RoutingTable> first_ =
      std::make_shared<const RoutingTable>(RoutingTable{{}, 0, std::vector<NodeId>(4), std::vector<Incarnation>(4)});
  Scratch scratch_;
  DelaunayStage stage_;
  TileContext context_;

 protected:
  std::unique_ptr<TileLife> tile_;
};

TEST_F(Words, AreBelievedOfTheSameEpoch) {
  hear_word(0);
  EXPECT_FALSE(introduced(splay()));
}

TEST_F(Words, AreBelievedOfTheNextEpochOnceItHasBegunHere) {
  rejoin();
  hear_word(1);
  EXPECT_FALSE(introduced(splay()));
}

// Who has told may have relied on one who is dead by now: he tells again, and so does whoever hears of it late.
TEST_F(Words, AreNotBelievedOfAnEarlierEpoch) {
  rejoin();
  hear_word(0);
  EXPECT_TRUE(introduced(splay()));
}

TEST_F(Words, AreNotBelievedOfAnEarlierEpochThatWaitedForTheTable) {
  hear_word(0);
  rejoin();
  EXPECT_TRUE(introduced(splay()));
}

TEST_F(Words, AMessageThatIsNoListOfPointsIsAnError) {
  ASSERT_TRUE(tile_->receive({{other, {}}, {self, {}}, {}, 1, BigVector<std::byte>(sizeof(SharedPoint) + 1)}));
  const Status splayed = tile_->step();
  ASSERT_FALSE(splayed);
  EXPECT_EQ(splayed.error().code, Errc::internal);
  EXPECT_NE(splayed.error().where.find("tile 2 has sent"), std::string::npos) << splayed.error().where;
}

}  // namespace
}  // namespace tessera::testing

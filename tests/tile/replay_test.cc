// What a tile tells again when others were reborn.
#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <vector>

#include "src/tiling/tile/tile_triangulation.h"

namespace tessera::testing {
namespace {

constexpr TileId self{0}, fence_owner{1}, other{2}, dead{3};

using Tiles = std::vector<TileId>;

// A triangle of its own; the points of others stand around it.
class Replay : public ::testing::Test {
 protected:
  Replay() : around_(make_around()) { renew(); }

  static KnownFromStart make_around() {
    Bounds bounds;
    bounds.add(Point{0, 0, 0});
    bounds.add(Point{30, 10, 0});
    return {{bounds, bounds, bounds, bounds}, {{}, {}, {fence_owner}, {}}, {}};
  }
  void renew() {
    tile_ =
        std::make_unique<TileTriangulation>(TileOptions{self, 2, KernelKind::flat, ExchangeRule::introduce, &around_});
  }
  void begin() { tile_->triangulate(own_, ids_); }
  void hear(TileId from, const SharedPoint& p) { ASSERT_TRUE(tile_->receive(from, std::span(&p, 1))); }
  void hear_fence() {
    for (const SharedPoint& p :
         {of(fence_owner, 0, 0, 3), of(fence_owner, 10, 0, 4), of(fence_owner, 0, 10, 5), of(fence_owner, 10, 10, 6)}) {
      hear(fence_owner, p);
    }
  }
  static SharedPoint of(TileId owner, double x, double y, std::uint64_t id, std::uint32_t told = 0) {
    return {{x, y, 0}, PointId{id}, owner, told};
  }
  // Whom it tells of the point now; when these are reborn.
  Tiles told_again(std::uint64_t id, const Tiles& reborn) {
    tile_->replay_to(reborn);
    return told(id);
  }
  Tiles told(std::uint64_t id) {
    Tiles tiles;
    for (const auto& [to, points] : tile_->take_updates()) {
      for (const SharedPoint& p : points) {
        if (p.id == PointId{id}) tiles.push_back(to);
      }
    }
    return tiles;
  }

  const std::vector<Point> own_{{4, 4, 0}, {5, 4, 0}, {4, 5, 0}};
  const std::vector<PointId> ids_{PointId{0}, PointId{1}, PointId{2}};
  const KnownFromStart around_;
  std::unique_ptr<TileTriangulation> tile_;
};

TEST_F(Replay, TellsTheRebornWhatItToldThemAndWhatItHeardFromThem) {
  begin();
  hear_fence();
  hear(other, of(dead, 6, 6, 7));
  tile_->introduce();
  tile_->take_updates();
  EXPECT_EQ(told_again(7, {other}), Tiles{other});   // heard from it
  EXPECT_EQ(told_again(1, {dead}), Tiles{dead});     // told it
  EXPECT_EQ(told_again(3, {fence_owner}), Tiles{});  // its own
}

// Who had told the fence's owner may have died before it heard.
TEST_F(Replay, TellsTheLivingOnceWhatItReliedOn) {
  begin();
  hear_fence();
  hear(other, of(other, 6, 6, 7, around_.bit(other, fence_owner)));
  tile_->introduce();
  EXPECT_EQ(told(7), Tiles{});
  EXPECT_EQ(told_again(7, {dead}), Tiles{fence_owner});
  EXPECT_EQ(told_again(7, {dead}), Tiles{});
  EXPECT_EQ(told_again(7, {fence_owner}), Tiles{fence_owner});
}

// Of a point that is no vertex, too, and when it has slept.
TEST_F(Replay, TellsOfRefusedPointsThatItReliedOn) {
  for (const bool by_told_bit : {false, true}) {
    SCOPED_TRACE(by_told_bit);
    renew();
    begin();
    hear_fence();
    const std::uint32_t word = by_told_bit ? around_.bit(other, fence_owner) : 0;
    hear(by_told_bit ? other : fence_owner, of(other, 30, 1, 7, word));
    tile_->introduce();
    ASSERT_EQ(tile_->counts().refused, 1u);
    tile_->take_updates();
    const BigVector<std::byte> image = tile_->save();
    renew();
    ASSERT_TRUE(tile_->load(image));
    EXPECT_EQ(told_again(7, {dead}), by_told_bit ? Tiles{fence_owner} : Tiles{});
    EXPECT_EQ(told_again(7, {fence_owner}), Tiles{fence_owner});
    hear(fence_owner, of(other, 30, 1, 7, word));
    EXPECT_EQ(tile_->counts().refused, 1u);  // it stays refused
  }
}

}  // namespace
}  // namespace tessera::testing

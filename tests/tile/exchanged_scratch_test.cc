// A tile whose scratch was exchanged with another's, or is older than its image: it is built again, or says so.
#include "src/delaunay/delaunay_program.h"
#include "src/exchange/tile_life.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <vector>

#include "src/base/random.h"
#include "tests/tile/scratch.h"
#include "tests/tile/setting.h"

namespace tessera::testing {
namespace {

constexpr std::uint32_t tiles = 2, points_each = 2000;

// Two tiles beside each other, of as many points, which leave their final cells on scratch.
class ExchangedScratch : public ::testing::Test {
 protected:
  ExchangedScratch() {
    Random random(7);
    std::vector<LocalPoint> all;
    std::vector<std::uint32_t> tile_of;
    std::vector<Bounds> bounds(tiles);
    for (std::uint32_t t = 0; t < tiles; ++t) {
      for (std::uint32_t i = 0; i < points_each; ++i) {
        const Point p{random.between(t, t + 1), random.between(0, 1), random.between(0, 1)};
        all.push_back({p, PointId{all.size()}});
        tile_of.push_back(t);
        points_[t].push_back(all.back());
        bounds[t].add(p);
      }
    }
    common_.reduce = true;
    common_.boxes = std::make_shared<const std::vector<Box>>(
        std::vector<Box>{{{-10, -10, -10}, {1, 10, 10}}, {{1, -10, -10}, {10, 10, 10}}});
    common_.around = std::make_shared<const KnownFromStart>(bounds, std::vector<std::vector<TileId>>(tiles),
                                                            make_seeds(all, tile_of, 3, Announced::spanning));
  }

  // A life of a tile, with what an earlier one has left.
  struct Life {
    Scratch scratch;
    TileContext context;
    std::unique_ptr<TileLife> state;
  };
  std::unique_ptr<Life> life(std::uint32_t tile, const Scratch* earlier = nullptr) const {
    auto made = std::make_unique<Life>(Life{Scratch(points_[tile], 3), {}, nullptr});
    auto stage = std::make_shared<DelaunayStage>(common_);
    if (earlier) made->scratch.inherit(*earlier);
    stage->storage = made->context.storage = &made->scratch;
    stage->store = &made->scratch;
    made->context.programs = std::move(stage);
    made->state = std::make_unique<TileLife>(TileIncarnation{TileId{tile}, {}}, made->context,
                                             std::make_shared<const RoutingTable>());
    return made;
  }
  // One that has been put to sleep.
  std::unique_ptr<Life> sleeper(std::uint32_t tile) const {
    auto made = life(tile);
    EXPECT_TRUE(made->state->begin());
    EXPECT_TRUE(made->state->step());
    made->state->take_outgoing();
    EXPECT_TRUE(made->state->sleep());
    return made;
  }
  static std::vector<std::int32_t> cells(Life& of) {
    of.state->take_outgoing();
    auto finished = of.state->finish();
    EXPECT_TRUE(finished) << finished.error().where;
    const TileMesh mesh = of.scratch.mesh_of(*finished.value());
    return {mesh.cells.begin(), mesh.cells.end()};
  }
  // What tile 0 gives that begins with what an earlier life has left.
  std::vector<std::int32_t> cells_from(const Scratch& earlier) const {
    const auto again = life(0, &earlier);
    const Status begun = again->state->begin();
    EXPECT_TRUE(begun) << begun.error().where;
    EXPECT_TRUE(again->state->step());
    return cells(*again);
  }
  static void replace(Scratch& in, ScratchKind what, Scratch& by) {
    const auto pieces = by.read({}, what).value();
    ASSERT_EQ(pieces.size(), 1u) << "the tile has left none";
    EXPECT_TRUE(in.write({}, what, pieces[0]));
  }

  std::vector<LocalPoint> points_[tiles];
  DelaunayStage common_;
};

TEST_F(ExchangedScratch, FinalCellsOfAnotherTileAreNotGoneOnWith) {
  const auto one = sleeper(0), other = sleeper(1);
  const auto expected = cells_from(one->scratch);
  replace(one->scratch, ScratchKind::finals, other->scratch);
  EXPECT_EQ(cells_from(one->scratch), expected);
}

TEST_F(ExchangedScratch, AnImageOfAnotherTileIsNotGoneOnWith) {
  const auto one = sleeper(0), other = sleeper(1);
  const auto expected = cells_from(one->scratch);
  replace(one->scratch, ScratchKind::state, other->scratch);
  EXPECT_EQ(cells_from(one->scratch), expected);
}

// A tile that slept and was awake when all was quiet: without its list of foreign vertices, as when a file of those was
// cut off, the image from before must not be taken for what it needs.
TEST_F(ExchangedScratch, AnImageFromBeforeTheEndOfTheExchangeIsNoSettledTile) {
  const auto one = sleeper(0);
  EXPECT_TRUE(can_be_built_alone(one->scratch, {}, false).value()) << "asleep it is";
  ASSERT_TRUE(one->state->step());
  one->state->take_outgoing();
  ASSERT_TRUE(one->state->settle());
  EXPECT_TRUE(can_be_built_alone(one->scratch, {}, false).value());
  ASSERT_TRUE(one->scratch.remove({}, ScratchKind::settled));
  EXPECT_FALSE(can_be_built_alone(one->scratch, {}, false).value());
}

TEST_F(ExchangedScratch, FinalCellsExchangedWhileTheTileSleepsAreDamage) {
  const auto one = sleeper(0), other = sleeper(1);
  replace(one->scratch, ScratchKind::finals, other->scratch);
  const auto collected = one->state->finish();
  ASSERT_FALSE(collected);
  EXPECT_EQ(collected.error().code, Errc::corrupt);
}

// Forged, so that image and list say that they belong to each other: the process goes on, and nothing begins from them
// again.
TEST_F(ExchangedScratch, FinalCellsThatFitByTheirChecksumAloneAreAnError) {
  const auto one = sleeper(0), other = sleeper(1);
  const auto expected = cells_from(one->scratch);
  const auto again = life(0, &one->scratch);
  replace(again->scratch, ScratchKind::finals, other->scratch);
  auto image = one->scratch.read({}, ScratchKind::state).value().at(0);
  const auto of_other = other->scratch.read({}, ScratchKind::state).value().at(0);
  constexpr std::size_t sum_bytes = 8;  // an image ends with it
  std::memcpy(&image[image.size() - sum_bytes], &of_other[of_other.size() - sum_bytes], sum_bytes);
  ASSERT_TRUE(again->scratch.write({}, ScratchKind::state, image));
  ASSERT_TRUE(again->state->begin());
  ASSERT_TRUE(again->state->step());
  const auto collected = again->state->finish();
  ASSERT_FALSE(collected);
  EXPECT_EQ(collected.error().code, Errc::corrupt) << collected.error().where;
  EXPECT_FALSE(again->scratch.has({}, ScratchKind::state).value());
  EXPECT_EQ(cells_from(again->scratch), expected);
}

}  // namespace
}  // namespace tessera::testing

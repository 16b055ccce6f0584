// How a tile lives, whatever its program does.
#include "src/exchange/tile_life.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "tests/exchange/greatest.h"
#include "tests/exchange/tile_scratch.h"

namespace tessera::testing {
namespace {

constexpr std::uint32_t tiles = 7;

// A chain of tiles, each with a scratch that outlives it.
class Chain : public ::testing::Test {
 protected:
  Chain() {
    auto stage = std::make_shared<GreatestStage>();
    stage->number = [](TileId t) { return numbers[t.value]; };
    stage->neighbours = [](TileId t) -> Result<std::vector<TileId>> {
      std::vector<TileId> neighbours;
      if (t.value > 0) neighbours.push_back(TileId{t.value - 1});
      if (t.value + 1 < tiles) neighbours.push_back(TileId{t.value + 1});
      return neighbours;
    };
    for (std::uint32_t t = 0; t < tiles; ++t) scratch_.push_back(std::make_unique<TileScratch>());
    stage_ = std::move(stage);
    for (std::uint32_t t = 0; t < tiles; ++t) bear(t);
  }
  static constexpr std::uint64_t numbers[] = {60, 10, 50, 20, 40, 5, 30};
  static constexpr std::uint64_t expected[] = {60, 60, 60, 50, 50, 40, 40};

  void bear(std::uint32_t t) {
    auto context = std::make_unique<TileContext>();
    context->programs = stage_;
    context->storage = scratch_[t].get();
    context->mail_bytes_max = 20;
    lives_[t] = std::make_unique<TileLife>(table_->peer_of(TileId{t}), *context, table_);
    contexts_[t] = std::move(context);
  }
  TileLife& tile(std::uint32_t t) { return *lives_[t]; }
  void post(std::uint32_t from) {
    for (Update& update : tile(from).take_outgoing()) mail_.push_back(std::move(update));
  }
  void begin(std::uint32_t t) {
    ASSERT_TRUE(tile(t).begin());
    post(t);
  }
  void deliver(std::size_t which) {
    Update update = std::move(mail_[which]);
    mail_.erase(mail_.begin() + static_cast<std::ptrdiff_t>(which));
    ASSERT_TRUE(tile(update.to.tile.value).receive(std::move(update)));
  }
  void step(std::uint32_t t) {
    ASSERT_TRUE(tile(t).step());
    post(t);
  }
  bool waits(std::uint32_t t) { return tile(t).waiting_updates() > 0; }
  void until_quiet() {
    for (bool busy = true; busy;) {
      while (!mail_.empty()) deliver(0);
      busy = false;
      for (std::uint32_t t = 0; t < tiles; ++t) {
        if (!waits(t)) continue;
        step(t);
        busy = true;
      }
    }
  }
  Totals totals() {
    Totals sum;
    for (std::uint32_t t = 0; t < tiles; ++t) sum += tile(t).totals();
    return sum;
  }
  std::uint64_t finish(std::uint32_t t) {
    auto finished = tile(t).finish();
    EXPECT_TRUE(finished) << finished.error().where;
    return finished ? static_cast<const GreatestFound&>(*finished.value()).number : 0;
  }
  void expect_right() {
    for (std::uint32_t t = 0; t < tiles; ++t) EXPECT_EQ(finish(t), expected[t]) << "tile " << t;
  }
  // A table in which these tiles are others, of which all the living hear.
  void lose(const std::vector<TileId>& lost) {
    auto next = std::make_shared<RoutingTable>(*table_);
    ++next->epoch.number;
    for (const TileId t : lost) ++next->incarnations[t.value].number;
    const auto rebirths = incarnation_changes_between(*table_, *next, nullptr);
    table_ = next;
    for (std::uint32_t t = 0; t < tiles; ++t) {
      if (std::find(lost.begin(), lost.end(), TileId{t}) != lost.end()) {
        bear(t);
      } else {
        tile(t).rejoin(table_, rebirths.get());
        post(t);
      }
    }
  }

  std::vector<std::unique_ptr<TileScratch>> scratch_;
  std::vector<Update> mail_;

 private:
  std::shared_ptr<const GreatestStage> stage_;
  std::shared_ptr<const RoutingTable> table_ = std::make_shared<const RoutingTable>(
      RoutingTable{{}, 0, std::vector<NodeId>(tiles), std::vector<Incarnation>(tiles)});
  std::map<std::uint32_t, std::unique_ptr<TileContext>> contexts_;
  std::map<std::uint32_t, std::unique_ptr<TileLife>> lives_;
};

TEST_F(Chain, EndsInWhatItsProgramsAreFor) {
  for (std::uint32_t t = 0; t < tiles; ++t) begin(t);
  until_quiet();
  EXPECT_EQ(totals().sent, totals().processed);
  EXPECT_GT(tile(2).hops(), 1u);
  expect_right();
}

TEST_F(Chain, KeepsMailUntilAStepAlsoForTilesThatHaveNotBegun) {
  begin(0);
  deliver(0);
  EXPECT_EQ(tile(1).waiting_updates(), 1u);
  EXPECT_EQ(tile(1).waiting_bytes(), 9u);
  EXPECT_EQ(tile(1).waiting_hops(), 1u);
  for (std::uint32_t t = 1; t < tiles; ++t) begin(t);
  until_quiet();
  EXPECT_EQ(tile(1).waiting_updates(), 0u);
  expect_right();
}

TEST_F(Chain, SleepsAndWakes) {
  for (std::uint32_t t = 0; t < tiles; ++t) {
    begin(t);
    ASSERT_TRUE(tile(t).sleep());
  }
  for (bool busy = true; busy;) {
    while (!mail_.empty()) deliver(mail_.size() - 1);
    busy = false;
    for (std::uint32_t t = 0; t < tiles; ++t) {
      if (!waits(t)) continue;
      step(t);
      ASSERT_TRUE(tile(t).sleep());
      busy = true;
    }
  }
  expect_right();
}

TEST_F(Chain, IsDamagedWhenTheImageOfASleeperIs) {
  begin(0);
  ASSERT_TRUE(tile(0).sleep());
  const std::byte garbage[3]{};
  ASSERT_TRUE(scratch_[0]->write({}, ScratchKind::state, garbage));
  const Status stepped = tile(0).step();
  ASSERT_FALSE(stepped);
  EXPECT_EQ(stepped.error().code, Errc::corrupt);
  EXPECT_EQ(stepped.error().where, "tile 0: its image on disk is damaged");
}

TEST_F(Chain, BeginsAnewFromAnImageThatIsNone) {
  const std::byte garbage[3]{};
  for (std::uint32_t t = 0; t < tiles; ++t) {
    ASSERT_TRUE(scratch_[t]->write({}, ScratchKind::state, garbage));
    begin(t);
  }
  until_quiet();
  expect_right();
}

TEST_F(Chain, CanBeFinishedAloneOnceItHasSettled) {
  for (std::uint32_t t = 0; t < tiles; ++t) begin(t);
  until_quiet();
  ASSERT_TRUE(tile(2).sleep());  // its image says it
  for (std::uint32_t t = 0; t < tiles; ++t) {
    ASSERT_TRUE(tile(t).settle());
    bear(t);
  }
  EXPECT_FALSE(scratch_[2]->has({}, ScratchKind::settled).value());
  expect_right();
}

TEST_F(Chain, GoesByTheLatestTableAlone) {
  for (std::uint32_t t = 0; t < tiles; ++t) begin(t);
  const std::vector<Update> of_the_dead = mail_;
  lose({TileId{2}});
  for (const Update& update : of_the_dead) {
    if (update.from.tile == TileId{2} || update.to.tile == TileId{2}) {
      ASSERT_TRUE(tile(update.to.tile.value).receive(Update(update)));
    }
  }
  EXPECT_FALSE(waits(2)) << "what was sent to its earlier life";
  begin(2);
  until_quiet();
  EXPECT_EQ(totals().sent, totals().processed);
  expect_right();
}

// Those that were reborn may have nothing to say that would wake it.
TEST_F(Chain, CallsItselfToAStepWhenOthersWereReborn) {
  for (std::uint32_t t = 0; t < tiles; ++t) begin(t);
  until_quiet();
  lose({TileId{2}});
  EXPECT_EQ(mail_.size(), tiles - 1);
  for (const Update& update : mail_) EXPECT_EQ(update.from.tile, update.to.tile);
  while (!mail_.empty()) deliver(0);
  step(1);
  const auto told = std::count_if(mail_.begin(), mail_.end(), [](const Update& u) { return u.to.tile == TileId{2}; });
  EXPECT_EQ(told, 2) << "its own number, and the greatest that it has passed on";
}

// Whatever is lost, in whatever order things happen.
TEST_F(Chain, IsRightAfterAnyLosses) {
  for (std::uint64_t seed = 0; seed < 2000 && !HasFailure(); ++seed) {
    std::mt19937_64 random(seed);
    mail_.clear();
    std::vector<bool> begun(tiles);
    std::vector<TileId> all;
    for (std::uint32_t t = 0; t < tiles; ++t) all.push_back(TileId{t});
    for (auto& scratch : scratch_) scratch = std::make_unique<TileScratch>();
    lose(all);
    mail_.clear();
    for (int left = 60; left > 0 || !mail_.empty() || std::count(begun.begin(), begun.end(), false) > 0; --left) {
      const auto t = static_cast<std::uint32_t>(random() % tiles);
      if (!begun[t]) {
        begin(t);
        begun[t] = true;
      } else if (left > 0 && random() % 12 == 0) {
        const bool image = random() % 2 == 0;
        if (!image) scratch_[t] = std::make_unique<TileScratch>();
        ASSERT_TRUE(scratch_[t]->remove({}, ScratchKind::mail));
        lose({TileId{t}});
        begun[t] = false;
      } else if (!mail_.empty() && random() % 2 == 0) {
        deliver(random() % mail_.size());
      } else if (waits(t)) {
        step(t);
        if (random() % 3 == 0) {
          ASSERT_TRUE(tile(t).sleep());
        }
      }
    }
    until_quiet();
    EXPECT_EQ(totals().sent, totals().processed) << seed;
    for (std::uint32_t t = 0; t < tiles; ++t) ASSERT_EQ(finish(t), expected[t]) << "tile " << t << ", seed " << seed;
  }
}

}  // namespace
}  // namespace tessera::testing

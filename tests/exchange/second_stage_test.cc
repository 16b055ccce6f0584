// A program that is no triangulation runs as the second stage after Delaunay, on the real actors, under every fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "actors/harness/harness.h"
#include "tests/exchange/greatest.h"

namespace tessera::testing {
namespace {

std::uint64_t number_of(TileId tile) { return tile.value * 7919ULL % 1009; }

using Tiles = std::map<TileId, TileMesh>;

// That the tile's cells have vertices of.
std::vector<TileId> touched(const Tiles& tiles, TileId tile) {
  const auto found = tiles.find(tile);
  if (found == tiles.end()) return {};
  std::set<TileId> owners(found->second.owners.begin(), found->second.owners.end());
  owners.erase(tile);
  return {owners.begin(), owners.end()};
}

class GreatestOfTiles final : public LaterStages {
 public:
  std::shared_ptr<const TilePrograms> programs(std::uint32_t, const Tiles& tiles) override {
    auto stage = std::make_shared<GreatestStage>();
    stage->number = number_of;
    stage->neighbours = [&tiles](TileId tile) -> Result<std::vector<TileId>> {
      if (!tiles.contains(tile)) return error(Errc::internal, "the stage before has not come to its end");
      return touched(tiles, tile);
    };
    stage->keep = [this](TileId tile, std::uint64_t number) {
      kept_[tile] = number;
      return success();
    };
    return stage;
  }
  std::vector<TileReceipt> stored(std::uint32_t) const override {
    std::vector<TileReceipt> stored;
    for (const auto& [tile, number] : kept_) stored.push_back({tile, {}});
    return stored;
  }
  std::string wrong(const Tiles& tiles) const override {
    for (const auto& [tile, mesh] : tiles) {
      std::uint64_t expected = number_of(tile);
      for (const TileId near : touched(tiles, tile)) {
        expected = std::max(expected, number_of(near));
        for (const TileId far : touched(tiles, near)) expected = std::max(expected, number_of(far));
      }
      const auto found = kept_.find(tile);
      if (found == kept_.end()) return "tile " + std::to_string(tile.value) + " has no number";
      if (found->second != expected)
        return "tile " + std::to_string(tile.value) + " has " + std::to_string(found->second) + ", not " +
               std::to_string(expected);
    }
    return kept_.size() == tiles.size() ? "" : "there are numbers of no tile";
  }

 private:
  std::map<TileId, std::uint64_t> kept_;
};

HarnessOptions options() {
  HarnessOptions options;
  options.kind = "lattice";
  options.dimension = 2;
  options.points = 30;
  options.tiles = 8;
  options.partition = PartitionKind::random;
  options.later_stages = [] { return std::make_unique<GreatestOfTiles>(); };
  return options;
}

// Of each test; nightly.sh runs more.
std::uint64_t seeds() {
  const char* wanted = std::getenv("SECOND_STAGE_SEEDS");
  return wanted == nullptr ? 300 : std::stoull(wanted);
}

HarnessReport run(HarnessOptions options) {
  options.first_seed = 1;
  options.last_seed = seeds();
  const HarnessReport report = run_harness(options);
  EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
  EXPECT_EQ(report.seeds, seeds());
  return report;
}

TEST(SecondStage, FollowsTheFirst) { run(options()); }

TEST(SecondStage, GoesOnAfterAccidentsAndRestarts) {
  HarnessOptions o = options();
  o.faults.storage = o.restarts = true;
  const HarnessReport report = run(o);
  EXPECT_GT(report.failures, 0u);
  EXPECT_GT(report.later_restarts, seeds() / 10);
}

TEST(SecondStage, SurvivesLosses) {
  HarnessOptions o = options();
  o.nodes = 3;
  o.faults.kill = o.faults.pause = o.faults.join = o.faults.coordinator = true;
  EXPECT_GT(run(o).epochs, 2 * seeds());
}

// Also that no tile begins again, in either stage.
TEST(SecondStage, GoesOnElsewhereWhenNodesLeave) {
  HarnessOptions o = options();
  o.nodes = 3;
  o.faults.leave = o.faults.join = true;
  run(o);
}

TEST(SecondStage, SurvivesAllAtOnce) {
  HarnessOptions o = options();
  o.nodes = 3;
  o.faults.kill = o.faults.pause = o.faults.join = o.faults.coordinator = o.faults.leave = o.faults.last = true;
  o.faults.all = true;
  run(o);
}

}  // namespace
}  // namespace tessera::testing

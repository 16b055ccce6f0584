// Tiles in memory that grow too large are split when they are stored, and nothing else changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "src/delaunay/live/live_result.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "tests/live/live_model.h"
#include "tests/store/sample_result.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t most_points = 9;  // of a tile

class LiveGrown : public ::testing::TestWithParam<LiveCase> {
 protected:
  void open(LiveOptions options = {.threads = 2, .tile_points = most_points}) {
    live_.reset();
    auto opened = LiveResult::open(folder_, options);
    ASSERT_TRUE(opened) << opened.error().where;
    live_ = std::move(opened).value();
  }
  void step(LiveModel& model) {
    const ResultChange change = model.next();
    const auto applied = live_->apply(change);
    ASSERT_EQ(applied.has_value(), model.allows(change)) << (applied ? "" : applied.error().where);
    if (applied) {
      model.apply(change);
    } else {
      model.skip();
    }
    EXPECT_EQ(model.compare(*live_->current()), "") << "at version " << model.version();
  }
  void expect_as_from_scratch(const LiveModel& model) const;
  std::size_t boxes() const { return read_manifest(folder_).value().boxes.size(); }

  test::TemporaryFolder scratch_;
  fs::path folder_ = scratch_.path() / "out";
  std::unique_ptr<LiveResult> live_;
};

// In the tiles that it has now, tile by tile.
void LiveGrown::expect_as_from_scratch(const LiveModel& model) const {
  const auto proof = verify(folder_, {}, {});
  ASSERT_TRUE(proof) << proof.error().where;
  const auto opened = TileSource::open(folder_);
  ASSERT_TRUE(opened) << opened.error().where;
  const Manifest& got = opened.value().manifest();
  const auto partition = Partition::from_json(got.partition);
  ASSERT_TRUE(partition) << partition.error().where;
  const test::TemporaryFolder scratch;
  const Manifest expected = model.store(scratch.path() / "out", partition.value());
  EXPECT_EQ(got.boxes, expected.boxes);
  EXPECT_EQ(got.digest, expected.digest);
  EXPECT_EQ(got.vertices, expected.vertices);
  EXPECT_EQ(got.cells, expected.cells);
  EXPECT_EQ(got.duplicates_xxh3, expected.duplicates_xxh3);
  EXPECT_EQ(got.duplicate_rows_xxh3, expected.duplicate_rows_xxh3);
  ASSERT_EQ(got.tiles.size(), expected.tiles.size());
  const auto other = TileSource::open(scratch.path() / "out");
  for (std::size_t i = 0; i < got.tiles.size(); ++i) {
    const TileEntry &a = got.tiles[i], &b = expected.tiles[i];
    EXPECT_EQ(std::tuple(a.tile, a.kind, a.own_points, a.points, a.cells, a.main_cells, a.digest),
              std::tuple(b.tile, b.kind, b.own_points, b.points, b.cells, b.main_cells, b.digest));
    if (partition.value().kind() != PartitionKind::random) {
      EXPECT_LE(a.own_points, most_points);
    }
    const auto here = opened.value().read(i, {.cells = true, .rows = true});
    const auto there = other.value().read(i, {.cells = true, .rows = true});
    ASSERT_TRUE(here && there);
    EXPECT_EQ(here.value().mesh.ids, there.value().mesh.ids);
    EXPECT_EQ(here.value().mesh.owners, there.value().mesh.owners);
    EXPECT_EQ(here.value().mesh.cells, there.value().mesh.cells);
    EXPECT_EQ(here.value().mesh.cell_ghost, there.value().mesh.cell_ghost);
    EXPECT_EQ(here.value().rows, there.value().rows);
  }
}

TEST_P(LiveGrown, IsTheResultFromScratchInTilesThatAreNotTooLarge) {
  LiveCase grown = GetParam();
  grown.grows = true;
  LiveModel model(grown, 90, 21);
  model.store(folder_);
  const std::size_t tiles = boxes();
  open();
  ASSERT_NE(live_, nullptr);
  bool emptied = false;
  for (int k = 0; k < 60; ++k) {
    step(model);
    if (k % 4 == 2) {
      const auto before = live_->current();
      const Status made = live_->checkpoint();
      ASSERT_TRUE(made) << made.error().where;
      EXPECT_EQ(live_->current()->number(), before->number());
      EXPECT_EQ(model.compare(*live_->current()), "");
      EXPECT_EQ(model.compare(*before), "");  // readers keep the tiles that they have
      expect_as_from_scratch(model);
      emptied |= read_manifest(folder_).value().tiles.size() < boxes();
    }
    if (k % 5 == 4) {
      open();
      ASSERT_NE(live_, nullptr);
      EXPECT_EQ(model.compare(*live_->current()), "");
    }
    if (HasFailure()) return;
  }
  if (GetParam().partition == PartitionKind::random) {
    EXPECT_EQ(boxes(), tiles);
  } else {
    EXPECT_TRUE(emptied);
    EXPECT_GT(boxes(), 2 * tiles);
    std::cout << "figures: " << tiles << " tiles in the beginning, " << boxes() << " in the end\n";
  }
}

INSTANTIATE_TEST_SUITE_P(Clouds, LiveGrown,
                         ::testing::Values(LiveCase{"uniform", 3, 9}, LiveCase{"uniform", 2, 9},
                                           LiveCase{"lattice", 3, 9, PartitionKind::octree}, LiveCase{"lattice", 2, 9},
                                           LiveCase{"lattice", 2, 12, PartitionKind::random},
                                           LiveCase{"uniform", 2, 9, PartitionKind::grid, TileKind::points},
                                           LiveCase{"lattice", 3, 9, PartitionKind::kdtree, TileKind::points, true},
                                           LiveCase{"lattice", 2, 9, PartitionKind::kdtree, TileKind::cells, true}),
                         [](const auto& info) {
                           const LiveCase& c = info.param;
                           return c.kind + std::to_string(c.dimension) + "D" + name_of(c.partition) +
                                  (c.store == TileKind::points ? "Points" : "") + (c.attributes ? "Attributes" : "");
                         });

class LiveGrownOne : public LiveGrown {};

TEST_F(LiveGrownOne, IsReadWhileItIsStored) {
  LiveModel model({.kind = "uniform", .dimension = 2, .tiles = 9, .grows = true}, 60, 7);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  std::atomic<bool> done{false};
  std::atomic<int> wrong{0}, asked{0};
  // The stars of all vertices of a cell have the cell.
  const auto read = [&](std::uint64_t seed) {
    while (!done || asked < 100) {
      const auto version = live_->current();
      const auto cell = version->locate({static_cast<double>(seed % 97) / 97, static_cast<double>(seed % 89) / 89, 0});
      seed = seed * 6364136223846793005u + 1442695040888963407u;
      if (!cell) continue;
      ++asked;
      auto wanted = cell->ids;
      std::sort(wanted.begin(), wanted.end());
      for (int i = 0; i < 3; ++i) {
        const auto star = version->star(cell->ids[i]);
        const bool there = star && std::any_of(star->begin(), star->end(), [&](const LiveCell& other) {
                             auto ids = other.ids;
                             std::sort(ids.begin(), ids.end());
                             return ids == wanted;
                           });
        if (!there) ++wrong;
      }
    }
  };
  std::jthread one(read, 1), two(read, 2);
  for (int k = 0; k < 120; ++k) {
    if (live_->apply(model.next())) {
      model.go_on();
    } else {
      model.skip();
    }
    if (k % 4 == 0) {
      EXPECT_TRUE(live_->checkpoint());
    }
  }
  done = true;
  one.join();
  two.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(boxes(), 20u);
  EXPECT_EQ(model.compare(*live_->current()), "");
}

TEST_F(LiveGrownOne, StaysAsItIsWhereThereIsNoMemoryForASplit) {
  LiveModel model({"uniform", 2, 1}, 300, 7);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  const std::uint64_t bytes = live_->current()->memory();
  open({.memory_bytes = 2 * bytes, .tile_points = 2});  // many small tiles take more
  ASSERT_NE(live_, nullptr);
  ASSERT_TRUE(live_->apply({.add = {{0.5, 0.25, 0}}}));
  const Status made = live_->checkpoint();
  ASSERT_TRUE(made) << made.error().where;
  EXPECT_EQ(boxes(), 1u);
  EXPECT_TRUE(verify(folder_, {}, {}));
  open();
  ASSERT_TRUE(live_->apply({.add = {{0.5, 0.375, 0}}}));
  ASSERT_TRUE(live_->checkpoint());
  EXPECT_GT(boxes(), 8u);
}

// A later program finds the limit in the result, also one that changes the result on disk.
TEST_F(LiveGrownOne, RemembersTheLimit) {
  LiveModel model({"uniform", 2, 9}, 90, 7);
  model.store(folder_);
  open({});
  ASSERT_TRUE(live_->apply({.add = {{0.5, 0.25, 0}}}));
  ASSERT_TRUE(live_->checkpoint());
  EXPECT_NE(read_manifest(folder_).value().partition.find("\"split_above\":20000"), std::string::npos)
      << read_manifest(folder_).value().partition;
  open();
  ASSERT_TRUE(live_->apply({.add = {{0.5, 0.375, 0}}}));
  ASSERT_TRUE(live_->checkpoint());
  open({});
  ASSERT_TRUE(live_->apply({.add = {{0.5, 0.125, 0}}}));
  ASSERT_TRUE(live_->checkpoint());
  EXPECT_NE(read_manifest(folder_).value().partition.find("\"split_above\":9"), std::string::npos);
}

// The list of source indices has removed ones, too, until they are the most.
TEST_F(LiveGrownOne, ForgetsTheSourceIndicesOfRemovedPoints) {
  LiveModel model({"uniform", 2, 4}, 90, 7);
  model.store(folder_);
  open({});
  ASSERT_NE(live_, nullptr);
  PointId last;
  for (int k = 0; k < 20; ++k) {
    std::vector<Point> add;
    std::vector<PointId> ids;
    for (int i = 0; i < 200; ++i) add.push_back({0.25 + 0.001 * i, 0.5 + 0.001 * k, 0});
    const auto added = live_->apply({.add = add});
    ASSERT_TRUE(added) << added.error().where;
    for (std::uint64_t i = 0; i < 200; ++i) ids.push_back(PointId{added.value().first_new + i});
    ASSERT_TRUE(live_->apply({.remove = ids}));
    last = ids.back();
  }
  EXPECT_GT(live_->current()->ids().size(), 4000u);
  ASSERT_TRUE(live_->checkpoint());
  EXPECT_EQ(live_->current()->ids().size(), 60u);
  EXPECT_EQ(model.compare(*live_->current()), "");
  const auto again = live_->apply({.remove = {last}});
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().where.find("there is no point " + to_string(last)), std::string::npos) << again.error().where;
}

}  // namespace
}  // namespace tessera::testing

// Results that grow to many times their size: tiles are split, and nothing else changes.
#include "src/delaunay/update/grown_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/delaunay/update/update.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "src/job/engine_steps.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "tests/store/sample_result.h"
#include "tests/update/stored_cloud.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

struct GrownCase {
  std::string kind;
  int dimension;
  PartitionKind partition;
  TileKind store;
  bool mixed = false;  // every third tile is of the other kind
};

class Grown : public ::testing::Test {
 protected:
  void make(const GrownCase& c, std::size_t count, std::size_t first, std::uint32_t tiles) {
    const auto all = make_cloud(c.kind, c.dimension, count, 7);
    for (const LocalPoint& p : all) pool_.push_back(p.at);
    Bounds bounds;
    for (std::size_t i = 0; i < first; ++i) bounds.add(pool_[i]);
    cloud_.dimension = c.dimension;
    cloud_.schema = some_schema();
    cloud_.partition = Partition::build_tiles(c.partition, c.dimension, {pool_.data(), first}, bounds, tiles);
    for (std::size_t i = 0; i < first; ++i) cloud_.points.push_back({pool_[i], PointId{i}});
    cloud_.points_read = first;
    cloud_.kind_of = [c](TileId tile) {
      const bool other = c.mixed && tile.value % 3 == 0;
      return other == (c.store == TileKind::cells) ? TileKind::points : TileKind::cells;
    };
    cloud_.store(now_);
  }

  // Into a new folder, or a new version.
  Updated update(const std::vector<Point>& add, const std::vector<PointId>& remove, UpdateOptions options) {
    ResultChange change{.add = add, .rows = {}, .remove = remove};
    std::vector<PointId> ids;
    for (std::size_t i = 0; i < add.size(); ++i) ids.push_back(PointId{cloud_.points_read + i});
    change.rows = cloud_.rows_of(ids);
    Engine engine(options.threads, std::uint64_t{1} << 30, kinds_of_stages());
    Progress progress;
    EngineStages stages(engine, {.threads = options.threads, .memory_bytes = std::uint64_t{1} << 30}, progress);
    const auto updated = update_result(now_, change, options, stages);
    EXPECT_TRUE(updated) << updated.error().where;
    if (!updated) return {};
    const std::set<PointId> gone(remove.begin(), remove.end());
    std::erase_if(cloud_.points, [&](const LocalPoint& p) { return gone.contains(p.id); });
    for (const Point& p : add) cloud_.points.push_back({p, PointId{cloud_.points_read++}});
    before_ = now_;
    if (!options.to.empty()) now_ = options.to;
    return updated.value();
  }
  fs::path other() { return folder_.path() / ("r" + std::to_string(++number_)); }
  Manifest manifest() const { return read_manifest(now_).value(); }
  std::uint64_t largest() const {
    std::uint64_t largest = 0;
    for (const TileEntry& entry : manifest().tiles) largest = std::max(largest, entry.own_points);
    return largest;
  }
  void expect_as_from_scratch();

  std::vector<Point> pool_;
  StoredCloud cloud_;  // what the result is of
  const test::TemporaryFolder folder_;
  fs::path now_ = folder_.path() / "r0", before_;
  int number_ = 0;
};

// As what is made of the same points with the same partition, tile by tile; files of cells byte for byte.
void Grown::expect_as_from_scratch() {
  const auto opened = TileSource::open(now_);
  ASSERT_TRUE(opened) << opened.error().where;
  const TileSource& source = opened.value();
  const Manifest& got = source.manifest();
  const auto partition = Partition::from_json(got.partition);
  ASSERT_TRUE(partition) << partition.error().where;
  cloud_.partition = partition.value();
  const test::TemporaryFolder scratch;
  const Manifest expected = cloud_.store(scratch.path() / "out");
  EXPECT_EQ(got.boxes, expected.boxes);
  EXPECT_EQ(got.digest, expected.digest);
  EXPECT_EQ(got.vertices, expected.vertices);
  EXPECT_EQ(got.cells, expected.cells);
  EXPECT_EQ(got.duplicates, expected.duplicates);
  EXPECT_EQ(got.bounds, expected.bounds);
  ASSERT_EQ(got.tiles.size(), expected.tiles.size());
  std::vector<TileMesh> meshes;
  for (std::size_t i = 0; i < got.tiles.size(); ++i) {
    TileEntry entry = got.tiles[i];
    entry.version = 1;
    // foreign vertices of points may be in another order; a part is of the kind of its tile
    if (entry.kind == TileKind::points || entry.kind != expected.tiles[i].kind) {
      entry.kind = expected.tiles[i].kind;
      entry.bytes = expected.tiles[i].bytes;
      entry.xxh3 = expected.tiles[i].xxh3;
    }
    EXPECT_EQ(entry, expected.tiles[i]) << "tile " << to_string(entry.tile);
    auto tile = source.read(i, {.cells = true, .rows = true});
    ASSERT_TRUE(tile) << tile.error().where;
    EXPECT_EQ(tile.value().rows, cloud_.rows_of(tile.value().mesh.ids));
    meshes.push_back(std::move(tile.value().mesh));
  }
  EXPECT_EQ(difference(global_delaunay(cloud_.points, cloud_.dimension), main_cells(meshes)), "");
  const auto verified = verify(now_, {}, {});
  EXPECT_TRUE(verified) << verified.error().where;
}

class GrownOf : public Grown, public ::testing::WithParamInterface<GrownCase> {};

TEST_P(GrownOf, IsTheResultFromScratchWithTilesThatAreNotTooLarge) {
  constexpr std::uint64_t limit = 40;
  make(GetParam(), 1000, 20, 2);
  std::mt19937_64 rng(3);
  std::size_t unused = 20, split = 0;
  for (int step = 0; unused < pool_.size(); ++step) {
    SCOPED_TRACE("change " + std::to_string(step));
    std::vector<Point> add;
    std::vector<PointId> remove;
    for (std::size_t k = unused + 10; k > 0 && unused < pool_.size(); --k) add.push_back(pool_[unused++]);
    for (int k = 0; k < 5; ++k) add.push_back(cloud_.points[rng() % cloud_.points.size()].at);  // duplicates
    for (const LocalPoint& p : cloud_.points) {
      if (step > 0 && rng() % 20 == 0) remove.push_back(p.id);
    }
    const Updated updated = update(add, remove,
                                   {.to = step % 2 == 0 ? fs::path() : other(),
                                    .threads = 2,
                                    .way = step % 3 == 2 ? UpdateWay::anew : UpdateWay::exchange,
                                    .tile_points = step == 0 ? limit : 0});
    split += updated.split;
    expect_as_from_scratch();
    EXPECT_LE(largest(), limit);
  }
  EXPECT_GT(split, 2u);
  EXPECT_GE(manifest().tiles.size(), cloud_.points.size() / limit);
}

std::vector<GrownCase> grown_cases() {
  std::vector<GrownCase> out;
  for (const int dimension : {2, 3}) {
    for (const std::string kind : {"uniform", "lattice", "sphere", "clusters", "corners"})
      out.push_back({kind, dimension, PartitionKind::kdtree, TileKind::cells});
    out.push_back({"uniform", dimension, PartitionKind::kdtree, TileKind::points});
    out.push_back({"lattice", dimension, PartitionKind::grid, TileKind::points});
    out.push_back({"planes", dimension, PartitionKind::octree, TileKind::cells, true});
  }
  return out;
}

INSTANTIATE_TEST_SUITE_P(Cases, GrownOf, ::testing::ValuesIn(grown_cases()), [](const auto& info) {
  return info.param.kind + std::to_string(info.param.dimension) + name_of(info.param.partition) +
         (info.param.store == TileKind::cells ? "cells" : "points");
});

TEST_F(Grown, ByManyPointsAtOnePlaceChangesOnlyTheFilesThere) {
  make({"uniform", 2, PartitionKind::kdtree, TileKind::cells}, 4000, 4000, 40);
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> offset(0, 1e-4);
  std::vector<Point> add;
  for (int k = 0; k < 10'000; ++k) add.push_back({0.4 + offset(rng), 0.6 + offset(rng), 0});
  const auto old = TileSource::open(now_).value();
  const Updated updated = update(add, {}, {.to = other(), .threads = 2, .tile_points = 500});
  EXPECT_EQ(updated.split, 1u);
  EXPECT_LE(largest(), 500u);
  expect_as_from_scratch();
  const auto next = TileSource::open(now_).value();
  std::size_t linked = 0;
  for (std::size_t i = 0; i < old.tiles(); ++i) {
    const auto same = next.find(old.entry(i).tile);
    ASSERT_TRUE(same);
    linked += fs::equivalent(old.file(i), next.file(*same)) ? 1 : 0;
  }
  EXPECT_GE(linked, 28u);
  const auto verified = verify(before_, {}, {});
  EXPECT_TRUE(verified) << "the old result stays as it is";
}

TEST_F(Grown, KeepsTilesOfAPartitionWithoutOrderInSpace) {
  make({"uniform", 3, PartitionKind::random, TileKind::cells}, 300, 60, 3);
  const std::vector<Point> add(pool_.begin() + 60, pool_.end());
  EXPECT_EQ(update(add, {}, {.to = other(), .threads = 2, .tile_points = 10}).split, 0u);
  expect_as_from_scratch();
}

TEST_F(Grown, RemembersTheLimit) {
  make({"uniform", 2, PartitionKind::kdtree, TileKind::cells}, 300, 300, 3);
  EXPECT_EQ(limit_of_tiles(manifest(), 0), grown_tile_least);
  EXPECT_EQ(limit_of_tiles(manifest(), 7), 7u);
  update({{0.5, 0.5, 0}}, {}, {.to = other(), .threads = 1});
  EXPECT_EQ(limit_of_tiles(manifest(), 0), grown_tile_least);
  update({{0.5, 0.6, 0}}, {}, {.to = {}, .threads = 1, .tile_points = 120});
  EXPECT_EQ(limit_of_tiles(manifest(), 0), 120u);
  Manifest large = manifest();
  large.partition = cloud_.partition.to_json();
  large.tiles.at(1).own_points = 1'000'000;
  EXPECT_EQ(limit_of_tiles(large, 0), 2'000'000u);
}

}  // namespace
}  // namespace tessera::testing

#include "src/delaunay/update/update.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/delaunay/update/select_points.h"
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

// As the command does it, in this process.
Result<Updated> update_here(const fs::path& result, const ResultChange& change, const UpdateOptions& options,
                            std::stop_token stop = {}, std::uint64_t memory_bytes = std::uint64_t{1} << 30) {
  Engine engine(options.threads, memory_bytes, kinds_of_stages());
  Progress progress;
  EngineStages stages(engine, {.threads = options.threads, .memory_bytes = memory_bytes}, progress);
  return update_result(result, change, options, stages, std::move(stop));
}

struct Case {
  std::string kind;
  int dimension;
  std::uint32_t tiles;
  PartitionKind partition;
  TileKind store;
  bool mixed = false;  // every third tile is of the other kind
};

class Update : public ::testing::Test {
 protected:
  // A result of all but a third of the points.
  void make(const Case& c, std::size_t count, std::uint64_t seed, bool attributes) {
    rng_.seed(seed);
    pool_.clear();
    for (const LocalPoint& p : make_cloud(c.kind, c.dimension, count, seed)) pool_.push_back(p.at);
    Bounds bounds;
    for (const Point& p : pool_) bounds.add(p);
    cloud_ = {};
    cloud_.dimension = c.dimension;
    cloud_.partition = Partition::build_tiles(c.partition, c.dimension, pool_, bounds, c.tiles);
    for (std::size_t i = 0; i < pool_.size() * 2 / 3; ++i) cloud_.points.push_back({pool_[i], PointId{i}});
    cloud_.points_read = cloud_.points.size();
    if (attributes) cloud_.schema = some_schema();
    cloud_.kind_of = [c](TileId tile) {
      const bool other = c.mixed && tile.value % 3 == 0;
      return other == (c.store == TileKind::cells) ? TileKind::points : TileKind::cells;
    };
    number_ = 0;
    cloud_.store(now());
  }
  fs::path now() const { return folder_.path() / ("r" + std::to_string(number_)); }
  fs::path next() const { return folder_.path() / ("r" + std::to_string(number_ + 1)); }

  ResultChange change(const std::vector<PointId>& remove, const std::vector<Point>& add) const {
    ResultChange out{.add = add, .rows = {}, .remove = remove};
    std::vector<PointId> ids;
    for (std::size_t i = 0; i < add.size(); ++i) ids.push_back(PointId{cloud_.points_read + i});
    if (!cloud_.schema.empty()) out.rows = some_rows(ids);
    return out;
  }
  // The same change of the points themselves.
  void apply(const ResultChange& change) {
    const std::set<PointId> gone(change.remove.begin(), change.remove.end());
    std::erase_if(cloud_.points, [&](const LocalPoint& p) { return gone.contains(p.id); });
    for (const Point& p : change.add) cloud_.points.push_back({p, PointId{cloud_.points_read++}});
  }
  Updated update(const ResultChange& change, unsigned threads = 2) {
    auto updated = update_here(now(), change, {.to = next(), .threads = threads, .way = way_});
    EXPECT_TRUE(updated) << (updated ? "" : updated.error().where);
    if (!updated) return {};
    apply(change);
    ++number_;
    return updated.value();
  }
  std::string refusal(const ResultChange& change) const {
    const auto updated = update_here(now(), change, {.to = next(), .threads = 2, .way = way_});
    EXPECT_FALSE(updated);
    EXPECT_FALSE(fs::exists(next()));
    std::size_t left = 0;
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder_.path())) ++left;
    EXPECT_EQ(left, number_ + 1u) << "something is left";
    return updated ? "" : updated.error().where;
  }
  void expect_as_from_scratch() const;

  std::mt19937_64 rng_;
  std::vector<Point> pool_;
  StoredCloud cloud_;  // what the result is of
  const test::TemporaryFolder folder_;
  std::size_t number_ = 0;
  UpdateWay way_ = UpdateWay::exchange;
};

// Tile by tile the same as what is made of the points that are left; files of cells byte for byte.
void Update::expect_as_from_scratch() const {
  const test::TemporaryFolder scratch;
  const Manifest expected = cloud_.store(scratch.path() / "out");
  const auto opened = TileSource::open(now());
  ASSERT_TRUE(opened) << opened.error().where;
  const TileSource& source = opened.value();
  const Manifest& got = source.manifest();
  EXPECT_EQ(got.digest, expected.digest);
  EXPECT_EQ(got.vertices, expected.vertices);
  EXPECT_EQ(got.cells, expected.cells);
  EXPECT_EQ(got.duplicates, expected.duplicates);
  EXPECT_EQ(got.points_read, expected.points_read);
  EXPECT_EQ(got.filtered, expected.filtered);
  EXPECT_EQ(got.bounds, expected.bounds);
  EXPECT_EQ(got.duplicates_xxh3, expected.duplicates_xxh3);
  ASSERT_EQ(got.tiles.size(), expected.tiles.size());
  std::vector<TileMesh> meshes;
  for (std::size_t i = 0; i < got.tiles.size(); ++i) {
    TileEntry entry = got.tiles[i];
    // foreign vertices of points may be in another order; a tile that had no file is of any kind
    if (entry.kind == TileKind::points || entry.kind != expected.tiles[i].kind) {
      entry.kind = expected.tiles[i].kind;
      entry.bytes = expected.tiles[i].bytes;
      entry.xxh3 = expected.tiles[i].xxh3;
    }
    EXPECT_EQ(entry, expected.tiles[i]) << "tile " << to_string(entry.tile);
    auto tile = source.read(i, {.cells = true, .rows = !cloud_.schema.empty()});
    ASSERT_TRUE(tile) << tile.error().where;
    if (!cloud_.schema.empty()) {
      EXPECT_EQ(tile.value().rows, some_rows(tile.value().mesh.ids));
    }
    meshes.push_back(std::move(tile.value().mesh));
  }
  EXPECT_EQ(difference(global_delaunay(cloud_.points, cloud_.dimension), main_cells(meshes)), "");
  const auto verified = verify(now(), {}, {});
  EXPECT_TRUE(verified) << verified.error().where;
}

class UpdateOf : public Update, public ::testing::WithParamInterface<Case> {};

TEST_P(UpdateOf, IsTheResultFromScratchAfterEachOfManyChanges) {
  make(GetParam(), 400, 3, true);
  std::size_t unused = cloud_.points.size();  // of the pool
  for (int step = 0; step < 6; ++step) {
    SCOPED_TRACE("change " + std::to_string(step));
    std::vector<PointId> remove;
    std::vector<Point> add;
    const Point center = cloud_.points[rng_() % cloud_.points.size()].at;
    for (const LocalPoint& p : cloud_.points) {
      const bool near = std::abs(p.at.x - center.x) + std::abs(p.at.y - center.y) < 0.2;
      const bool tile = cloud_.partition.tile_of(p.at) == cloud_.partition.tile_of(center);
      const bool few = cloud_.points.size() < 100;
      if (!few && (step == 1 ? near : step == 3 ? tile && GetParam().tiles > 1 : step != 0 && rng_() % 20 == 0))
        remove.push_back(p.id);
    }
    for (int k = 0; k < (step == 0 ? 1 : step == 1 ? 0 : 30) && unused < pool_.size(); ++k)
      add.push_back(pool_[unused++]);
    way_ = step == 2 || step == 5 ? UpdateWay::anew : UpdateWay::exchange;
    const Updated updated = update(change(remove, add), 1 + static_cast<unsigned>(step) % 3);
    EXPECT_EQ(updated.removed, remove.size());
    EXPECT_LE(updated.begun, updated.awake);
    expect_as_from_scratch();
  }
}

std::vector<Case> cases() {
  std::vector<Case> out;
  for (const int dimension : {2, 3}) {
    for (const std::string kind : {"uniform", "lattice", "sphere", "planes", "clusters"}) {
      out.push_back({kind, dimension, 7, PartitionKind::kdtree, TileKind::cells});
    }
    out.push_back({"lattice", dimension, 1, PartitionKind::kdtree, TileKind::cells});
    out.push_back({"uniform", dimension, 60, PartitionKind::kdtree, TileKind::points});
    out.push_back({"lattice", dimension, 60, PartitionKind::grid, TileKind::cells, true});
    out.push_back({"slab", dimension, 7, PartitionKind::random, TileKind::points});
    out.push_back({"jitter", dimension, 5, PartitionKind::octree, TileKind::points, true});
  }
  return out;
}

INSTANTIATE_TEST_SUITE_P(Cases, UpdateOf, ::testing::ValuesIn(cases()), [](const auto& info) {
  return info.param.kind + std::to_string(info.param.dimension) + "of" + std::to_string(info.param.tiles) +
         (info.param.store == TileKind::cells ? "cells" : "points");
});

// Of a cloud with a class for each point.
class Selection : public ::testing::Test {
 protected:
  Selection() {
    cloud_.dimension = 2;
    std::uint64_t id = 0;
    Bounds bounds;
    for (const LocalPoint& p : make_cloud("uniform", 2, 300, 1)) {
      cloud_.points.push_back({p.at, PointId{id++}});
      bounds.add(p.at);
      places_.push_back(p.at);
    }
    cloud_.points.push_back({places_[7], PointId{id++}});  // a duplicate
    cloud_.points_read = id;
    cloud_.partition = Partition::build_tiles(PartitionKind::kdtree, 2, places_, bounds, 9);
    cloud_.schema = {{"some", AttributeType::u8}, {"classification", AttributeType::u8}};
    cloud_.row_of = [](PointId point) {
      return std::vector<std::byte>{std::byte{9}, static_cast<std::byte>(point.value % 5)};
    };
    cloud_.store(folder_.path() / "r");
  }
  std::vector<PointId> select(const PointSelection& selection) const {
    const auto source = TileSource::open(folder_.path() / "r").value();
    auto selected = select_points(source, selection, 2, {});
    EXPECT_TRUE(selected) << (selected ? "" : selected.error().where);
    return selected ? selected.value() : std::vector<PointId>{};
  }
  StoredCloud cloud_;
  std::vector<Point> places_;
  const test::TemporaryFolder folder_;
};

TEST_F(Selection, HasTheVerticesOfABoxOrAClassAndTheirDuplicates) {
  const Box box{{0.2, 0.1, -1}, {0.4, 0.9, 1}};
  std::vector<PointId> in_box, of_class;
  for (const LocalPoint& p : cloud_.points) {
    const bool duplicate = p.id.value == places_.size();
    if (box.lo.x <= p.at.x && p.at.x <= box.hi.x && box.lo.y <= p.at.y && p.at.y <= box.hi.y) in_box.push_back(p.id);
    if ((duplicate ? 7 : p.id.value) % 5 == 2) of_class.push_back(p.id);
  }
  EXPECT_EQ(select({.box = box}), in_box);
  EXPECT_EQ(select({.classes = {2}}), of_class);
  std::vector<PointId> both;
  std::set_union(in_box.begin(), in_box.end(), of_class.begin(), of_class.end(), std::back_inserter(both));
  EXPECT_EQ(select({.box = box, .classes = {2}}), both);
  EXPECT_TRUE(select({.classes = {200}}).empty());
  EXPECT_TRUE(select({}).empty());
}

class UpdateBy : public Update, public ::testing::WithParamInterface<UpdateWay> {
 protected:
  UpdateBy() { way_ = GetParam(); }
};
INSTANTIATE_TEST_SUITE_P(Ways, UpdateBy, ::testing::Values(UpdateWay::exchange, UpdateWay::anew),
                         [](const auto& info) { return info.param == UpdateWay::anew ? "Anew" : "Exchange"; });

constexpr std::uint64_t seed = 5;
const Case usual{"uniform", 3, 20, PartitionKind::kdtree, TileKind::cells};
const Case planar{"uniform", 2, 20, PartitionKind::kdtree, TileKind::cells};

TEST_F(Update, OfOnePointWakesFewTilesAndLinksTheOthers) {
  make(planar, 6000, seed, false);
  const auto before = TileSource::open(now()).value();
  const fs::path old = now();
  const Updated updated = update(change({cloud_.points[17].id}, {}));
  expect_as_from_scratch();
  EXPECT_LE(updated.awake, 4u);
  EXPECT_LE(updated.written, 3u);
  const auto after = TileSource::open(now()).value();
  std::size_t linked = 0;
  for (std::size_t i = 0; i < after.tiles(); ++i) linked += fs::equivalent(before.file(i), after.file(i)) ? 1 : 0;
  EXPECT_EQ(linked, after.tiles() - updated.written);
  const auto verified = verify(old, {}, {});
  EXPECT_TRUE(verified) << "the old result stays as it is";
}

// Each side of the hole must not take far points for its neighbours and ask tile after tile.
TEST_F(Update, OfAHoleWhereTilesMeetWakesTheTilesAroundItAlone) {
  make({"uniform", 2, 64, PartitionKind::kdtree, TileKind::cells}, 12'000, seed, false);
  std::vector<PointId> remove;
  for (const LocalPoint& p : cloud_.points) {
    if (std::hypot(p.at.x - 0.5, p.at.y - 0.5) < 0.05) remove.push_back(p.id);
  }
  ASSERT_GT(remove.size(), 30u);
  const Updated updated = update(change(remove, {}));
  EXPECT_GE(updated.begun, 4u);
  EXPECT_LE(updated.awake, 12u);
  expect_as_from_scratch();
}

TEST_F(Update, ThatIsDryWritesNothingAndTellsTheSame) {
  make(planar, 600, seed, true);
  const ResultChange wanted = change({cloud_.points[17].id, cloud_.points[18].id}, {{0.5, 0.5, 0}});
  const auto dry = update_here(now(), wanted, {.threads = 2, .dry_run = true});
  ASSERT_TRUE(dry) << dry.error().where;
  EXPECT_FALSE(fs::exists(next()));
  const Updated updated = update(wanted);
  EXPECT_EQ(dry.value().removed, 2u);
  EXPECT_EQ(dry.value().begun, updated.begun);
  EXPECT_EQ(dry.value().awake, updated.awake);
  EXPECT_EQ(dry.value().written, updated.written);
}

// The same tiles as with much memory, where hardly two tiles fit, and those that wait are on disk.
TEST_F(Update, WorksInLittleMemory) {
  make({"lattice", 3, 30, PartitionKind::kdtree, TileKind::cells}, 3000, seed, true);
  std::vector<PointId> remove;
  for (const LocalPoint& p : cloud_.points) {
    if (rng_() % 40 == 0) remove.push_back(p.id);
  }
  const ResultChange wanted = change(remove, {{0.4, 0.5, 0.3}, {-3, 0.2, 0.9}});
  for (const UpdateWay way : {UpdateWay::exchange, UpdateWay::anew}) {
    const auto updated = update_here(now(), wanted, {.to = next(), .threads = 2, .way = way}, {}, 1 << 20);
    ASSERT_TRUE(updated) << updated.error().where;
    if (way == UpdateWay::exchange) fs::remove_all(next());
  }
  apply(wanted);
  ++number_;
  expect_as_from_scratch();
}

TEST_F(Update, OfNothingLinksEverything) {
  make(planar, 300, seed, true);
  const Updated updated = update(change({}, {}));
  EXPECT_EQ(updated.awake, 0u);
  EXPECT_EQ(updated.written, 0u);
  expect_as_from_scratch();
}

TEST_P(UpdateBy, TakesNewPointsAtOldPlacesAsDuplicates) {
  make(usual, 300, seed, false);
  const Point at = cloud_.points[40].at;
  const Updated updated = update(change({}, {at, {9, 9, 9}, at, {9, 9, 9}}));
  EXPECT_EQ(updated.duplicates, 3u);
  expect_as_from_scratch();
  // one of the duplicates goes, then the vertex, then the heir
  update(change({PointId{cloud_.points_read - 2}}, {}));
  expect_as_from_scratch();
  update(change({PointId{40}}, {}));
  expect_as_from_scratch();
  const PointId heir =
      std::find_if(cloud_.points.begin(), cloud_.points.end(), [&](auto& p) { return p.at == at; })->id;
  update(change({heir}, {at}));
  expect_as_from_scratch();
  update(change({PointId{cloud_.points_read - 1}}, {}));
  expect_as_from_scratch();
}

TEST_P(UpdateBy, RemovesAVertexWithAttributesTogetherWithItsDuplicatesAlone) {
  make(usual, 300, seed, true);
  update(change({}, {cloud_.points[40].at}));
  expect_as_from_scratch();
  EXPECT_NE(refusal(change({PointId{40}}, {})).find("point 40 cannot be removed alone"), std::string::npos);
  update(change({PointId{40}, PointId{cloud_.points_read - 1}}, {}));
  expect_as_from_scratch();
}

TEST_P(UpdateBy, ReplacesAllPoints) {
  make(usual, 300, seed, true);
  std::vector<PointId> all;
  for (const LocalPoint& p : cloud_.points) all.push_back(p.id);
  const std::vector<Point> others(pool_.begin() + static_cast<std::ptrdiff_t>(cloud_.points.size()), pool_.end());
  update(change(all, others));
  expect_as_from_scratch();
}

TEST_P(UpdateBy, TakesAPointFarOutsideAllBounds) {
  make(usual, 300, seed, true);
  update(change({}, {{1e9, -3e7, 2}}));
  expect_as_from_scratch();
  update(change({PointId{cloud_.points_read - 1}}, {}));
  expect_as_from_scratch();
}

TEST_P(UpdateBy, RefusesWhatCannotBeAndLeavesNothing) {
  make(usual, 300, seed, false);
  EXPECT_NE(refusal(change({PointId{1000}}, {})).find("there is no point 1000 to remove"), std::string::npos);
  EXPECT_NE(refusal(change({}, {{0, std::numeric_limits<double>::quiet_NaN(), 0}})).find("not finite"),
            std::string::npos);
  std::vector<PointId> all;
  for (const LocalPoint& p : cloud_.points) all.push_back(p.id);
  EXPECT_NE(refusal(change(all, {})).find("no points would be left"), std::string::npos);
  std::vector<Point> flat;
  for (int i = 0; i < 50; ++i) flat.push_back({i % 7 / 7.0, i / 50.0, 0.5});
  EXPECT_NE(refusal(change(all, flat)).find("in a plane"), std::string::npos);
  update(change({PointId{3}}, {}));
  EXPECT_NE(refusal(change({PointId{3}}, {})).find("there is no point 3 to remove"), std::string::npos);
  expect_as_from_scratch();
}

TEST_F(Update, RefusesAFolderThatExists) {
  make(usual, 100, seed, false);
  const auto updated = update_here(now(), {}, {.to = now(), .threads = 1});
  ASSERT_FALSE(updated);
  EXPECT_EQ(updated.error().code, Errc::usage);
  EXPECT_NE(updated.error().where.find("exists already"), std::string::npos);
}

TEST_P(UpdateBy, StopsWhenItIsAskedTo) {
  make(usual, 100, seed, false);
  std::stop_source stop;
  stop.request_stop();
  const auto updated =
      update_here(now(), change({PointId{3}}, {}), {.to = next(), .threads = 2, .way = way_}, stop.get_token());
  ASSERT_FALSE(updated);
  EXPECT_EQ(updated.error().code, Errc::interrupted) << updated.error().where;
  EXPECT_FALSE(fs::exists(next()));
}

}  // namespace
}  // namespace tessera::testing

// Points at few places, most of them equal to others: a result in memory is, after each batch, what update_result()
// makes of the same changes, with the same vertices, duplicates and attributes, whichever of equal points is kept.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/delaunay/live/live_result.h"
#include "src/delaunay/update/select_points.h"
#include "src/delaunay/update/update.h"
#include "src/job/engine_steps.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "tests/store/sample_result.h"
#include "tests/update/stored_cloud.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

struct LiveEqualCase {
  int dimension = 2;
  std::uint32_t tiles = 7;
  TileKind store = TileKind::cells;
  DuplicatePolicy keep = DuplicatePolicy::first;
  bool attributes = true;
};

class LiveEqual : public ::testing::TestWithParam<LiveEqualCase> {
 protected:
  void SetUp() override {
    const LiveEqualCase& c = GetParam();
    Bounds bounds;
    std::vector<Point> places;
    for (std::uint64_t i = 0; i < 150; ++i) places.push_back(some_place());
    for (const Point& p : places) bounds.add(p);
    cloud_.dimension = c.dimension;
    cloud_.partition = Partition::build_tiles(PartitionKind::kdtree, c.dimension, places, bounds, c.tiles);
    for (const Point& p : places) cloud_.points.push_back({p, PointId{cloud_.points_read++}});
    cloud_.keep = c.keep;
    if (c.attributes) {
      cloud_.schema = {{c.dimension == 2 ? "z" : "height", AttributeType::f64}, {"some", AttributeType::u32}};
      cloud_.row_of = row_with_height;
    }
    cloud_.kind_of = [c](TileId) { return c.store; };
    cloud_.store(live_folder_);
    cloud_.store(stored());
    open();
  }
  void open() {
    live_.reset();
    auto opened = LiveResult::open(live_folder_, {.threads = 2});
    ASSERT_TRUE(opened) << opened.error().where;
    live_ = std::move(opened).value();
  }
  Point some_place() {
    const auto axis = [&](unsigned wide) { return static_cast<double>(rng_() % wide); };
    return GetParam().dimension == 2 ? Point{axis(7), axis(7), 0} : Point{axis(4), axis(3), axis(4)};
  }
  fs::path stored() const { return scratch_.path() / ("stored" + std::to_string(number_)); }

  ResultChange some_change(int step) {
    ResultChange out;
    const Point emptied = some_place();
    for (const LocalPoint& p : cloud_.points) {
      const bool goes = step % 5 == 2   ? p.at == emptied
                        : step % 5 == 4 ? false
                                        : rng_() % (cloud_.points.size() > 100 ? 3 : 9) == 0;
      if (goes) out.remove.push_back(p.id);
    }
    std::vector<PointId> ids;
    for (int k = 0; k < (step % 5 == 1 ? 0 : 30); ++k) {
      ids.push_back(PointId{cloud_.points_read + out.add.size()});
      out.add.push_back(some_place());
    }
    if (GetParam().attributes) out.rows = cloud_.rows_of(ids);
    return out;
  }

  // The change in which also equal points are removed, as the command finds them.
  ResultChange with_equal(const ResultChange& change) const {
    const auto source = TileSource::open(stored()).value();
    const auto equal = select_points(source, {.places = change.add}, 1, {});
    EXPECT_TRUE(equal) << equal.error().where;
    std::set<PointId> all(change.remove.begin(), change.remove.end());
    all.insert(equal.value().begin(), equal.value().end());
    return {.add = change.add, .rows = change.rows, .remove = {all.begin(), all.end()}};
  }

  Updated update(const ResultChange& change) {
    Engine engine(1, std::uint64_t{1} << 30, kinds_of_stages());
    Progress progress;
    EngineStages stages(engine, {.threads = 1, .memory_bytes = std::uint64_t{1} << 30}, progress);
    const fs::path before = stored();
    ++number_;
    const auto updated =
        update_result(before, change, {.to = stored(), .tile_points = 1'000'000, .command = {"test"}}, stages);
    EXPECT_TRUE(updated) << updated.error().where;
    const std::set<PointId> gone(change.remove.begin(), change.remove.end());
    std::erase_if(cloud_.points, [&](const LocalPoint& p) { return gone.contains(p.id); });
    for (const Point& p : change.add) cloud_.points.push_back({p, PointId{cloud_.points_read++}});
    return updated ? updated.value() : Updated{};
  }

  void expect_same();

  std::mt19937_64 rng_{17};
  StoredCloud cloud_;  // what both results are of
  const test::TemporaryFolder scratch_;
  const fs::path live_folder_ = scratch_.path() / "live";
  std::unique_ptr<LiveResult> live_;
  int number_ = 0, written_ = 0;
};

// As the updated result, and as one from scratch.
void LiveEqual::expect_same() {
  const fs::path written = scratch_.path() / ("written" + std::to_string(++written_));
  const auto made = live_->write_to(written);
  ASSERT_TRUE(made) << made.error().where;
  const auto proof = verify(written, {}, {});
  EXPECT_TRUE(proof) << proof.error().where;
  const test::TemporaryFolder scratch;
  cloud_.store(scratch.path() / "out");
  const auto got = TileSource::open(written);
  ASSERT_TRUE(got) << got.error().where;
  for (const fs::path& other : {stored(), scratch.path() / "out"}) {
    SCOPED_TRACE(other.string());
    const auto expected = TileSource::open(other);
    ASSERT_TRUE(expected) << expected.error().where;
    const Manifest &a = got.value().manifest(), &b = expected.value().manifest();
    EXPECT_EQ(a.digest, b.digest);
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.duplicates, b.duplicates);
    EXPECT_EQ(a.duplicates_xxh3, b.duplicates_xxh3);
    EXPECT_EQ(a.duplicate_rows_xxh3, b.duplicate_rows_xxh3);
    EXPECT_EQ(a.points_read, b.points_read);
    EXPECT_EQ(a.filtered, b.filtered);
    EXPECT_EQ(a.bounds, b.bounds);
    ASSERT_EQ(a.tiles.size(), b.tiles.size());
    for (std::size_t i = 0; i < a.tiles.size(); ++i) {
      EXPECT_EQ(a.tiles[i].digest, b.tiles[i].digest);
      const auto here = got.value().read(i, {.cells = true, .rows = true});
      const auto there = expected.value().read(i, {.cells = true, .rows = true});
      ASSERT_TRUE(here && there);
      EXPECT_EQ(here.value().mesh.ids, there.value().mesh.ids);
      EXPECT_EQ(here.value().rows, there.value().rows);
    }
  }
}

TEST_P(LiveEqual, IsWhatAnUpdateOfTheSameChangesMakes) {
  for (int step = 0; step < 15; ++step) {
    SCOPED_TRACE("change " + std::to_string(step));
    const ResultChange change = some_change(step);
    const bool replaces = step % 3 == 2;
    const auto applied = live_->apply(change, replaces ? EqualToNew::go : EqualToNew::stay);
    ASSERT_TRUE(applied) << applied.error().where;
    const Updated updated = update(replaces ? with_equal(change) : change);
    EXPECT_EQ(applied.value().removed, updated.removed);
    EXPECT_EQ(applied.value().equal.size(), updated.duplicates);
    if (HasFailure()) return;
    expect_same();
    if (step % 4 == 3) {
      const Status made = live_->checkpoint();
      ASSERT_TRUE(made) << made.error().where;
      expect_same();
    }
    if (step % 3 == 1) {  // again, from the log
      open();
      expect_same();
    }
    if (HasFailure()) return;
  }
}

std::vector<LiveEqualCase> equal_cases() {
  std::vector<LiveEqualCase> out;
  for (const auto keep :
       {DuplicatePolicy::first, DuplicatePolicy::last, DuplicatePolicy::lowest, DuplicatePolicy::highest}) {
    out.push_back({2, 7, TileKind::cells, keep});
    out.push_back({2, 1, TileKind::points, keep});
    out.push_back({2, 40, TileKind::points, keep});
  }
  out.push_back({3, 7, TileKind::cells, DuplicatePolicy::first});
  out.push_back({3, 7, TileKind::points, DuplicatePolicy::last});
  out.push_back({2, 7, TileKind::cells, DuplicatePolicy::last, false});
  return out;
}

INSTANTIATE_TEST_SUITE_P(Cases, LiveEqual, ::testing::ValuesIn(equal_cases()), [](const auto& info) {
  const LiveEqualCase& c = info.param;
  return std::string(name_of(c.keep)) + std::to_string(c.dimension) + "of" + std::to_string(c.tiles) +
         (c.store == TileKind::cells ? "cells" : "points") + (c.attributes ? "" : "alone");
});

}  // namespace
}  // namespace tessera::testing

// A result that is kept in memory is, after each batch, CGAL's triangulation of its points; and nothing else changes
// it.
#include "src/delaunay/live/live_result.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/delaunay/update/update.h"
#include "src/geometry/reference/clouds.h"
#include "src/job/engine_steps.h"
#include "src/result/measure/measure.h"
#include "src/result/store/duplicate_rows.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "tests/live/live_model.h"
#include "tests/store/sample_result.h"
#include "tests/update/stored_cloud.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

class Live : public ::testing::TestWithParam<LiveCase> {
 protected:
  void open(unsigned threads = 1) {
    live_.reset();
    auto opened = LiveResult::open(folder_, {.threads = threads, .tile_points = tile_points_});
    ASSERT_TRUE(opened) << opened.error().where;
    live_ = std::move(opened).value();
  }
  // Applies the model's next batch, or sees it refused.
  void step(LiveModel& model) {
    const ResultChange change = model.next();
    const auto before = live_->current();
    const auto applied = live_->apply(change);
    if (!model.allows(change)) {
      EXPECT_FALSE(applied);
      EXPECT_EQ(live_->current(), before);
      model.skip();
      return;
    }
    ASSERT_TRUE(applied) << applied.error().where;
    EXPECT_EQ(applied.value().first_new, model.first_new());
    EXPECT_EQ(applied.value().removed, change.remove.size());
    model.apply(change);
    EXPECT_EQ(model.compare(*live_->current()), "") << "at version " << model.version();
  }

  test::TemporaryFolder scratch_;
  fs::path folder_ = scratch_.path() / "out";
  std::unique_ptr<LiveResult> live_;
  std::uint64_t tile_points_ = 0;  // LiveOptions
};

// Attributes of all vertices and duplicates that are stored, compared with what their points were added with.
void check_rows(const fs::path& folder) {
  const auto source = TileSource::open(folder);
  ASSERT_TRUE(source);
  const Manifest& manifest = source.value().manifest();
  for (std::size_t i = 0; i < source.value().tiles(); ++i) {
    const auto tile = source.value().read(i, {.cells = false, .rows = true});
    ASSERT_TRUE(tile) << tile.error().where;
    EXPECT_EQ(tile.value().rows, some_rows(tile.value().mesh.ids));
  }
  if (manifest.duplicates == 0) return;
  const auto rows = DuplicateRows::open(folder, manifest);
  const auto pairs = read_duplicates(folder, manifest);
  ASSERT_TRUE(rows && rows.value() && pairs);
  for (std::size_t i = 0; i < pairs.value().size(); ++i) {
    const auto row = rows.value()->row(i);
    EXPECT_EQ(std::vector<std::byte>(row.begin(), row.end()), some_rows({pairs.value()[i].duplicate}));
  }
}

TEST_P(Live, IsTheTriangulationOfItsPointsAfterEachBatch) {
  LiveModel model(GetParam(), 60, 1);
  model.store(folder_);
  open(2);
  ASSERT_NE(live_, nullptr);
  EXPECT_EQ(model.compare(*live_->current()), "");
  for (int k = 0; k < 40; ++k) {
    step(model);
    if (HasFailure()) return;
    if (k % 10 == 6) {
      const Status made = live_->checkpoint();
      ASSERT_TRUE(made) << made.error().where;
      const auto proof = verify(folder_, {}, {});
      ASSERT_TRUE(proof) << proof.error().where;
      if (GetParam().attributes && !GetParam().old_software) check_rows(folder_);
    }
    if (k % 5 == 4) {  // again, from the log
      open();
      ASSERT_NE(live_, nullptr);
      EXPECT_EQ(model.compare(*live_->current()), "");
    }
  }
  const auto written = live_->write_to(scratch_.path() / "next");
  ASSERT_TRUE(written) << written.error().where;
  const auto proof = verify(scratch_.path() / "next", {}, {});
  ASSERT_TRUE(proof) << proof.error().where;
  folder_ = scratch_.path() / "next";
  open();
  ASSERT_NE(live_, nullptr);
  EXPECT_EQ(model.compare(*live_->current()), "");
  step(model);
}

INSTANTIATE_TEST_SUITE_P(
    Clouds, Live,
    ::testing::Values(LiveCase{"uniform", 3}, LiveCase{"uniform", 2}, LiveCase{"lattice", 3}, LiveCase{"lattice", 2},
                      LiveCase{"lattice", 3, 12, PartitionKind::random}, LiveCase{"lattice", 2, 1},
                      LiveCase{"uniform", 2, 20, PartitionKind::grid, TileKind::points},
                      LiveCase{"lattice", 3, 5, PartitionKind::kdtree, TileKind::points, true},
                      LiveCase{"lattice", 2, 9, PartitionKind::kdtree, TileKind::cells, true},
                      LiveCase{"lattice", 2, 5, PartitionKind::kdtree, TileKind::cells, true, true}),
    [](const auto& info) {
      const LiveCase& c = info.param;
      return c.kind + std::to_string(c.dimension) + "D" + std::to_string(c.tiles) + name_of(c.partition) +
             (c.store == TileKind::points ? "Points" : "") + (c.attributes ? "Attributes" : "") +
             (c.old_software ? "OfOldSoftware" : "");
    });

class LiveOne : public Live {};

TEST_F(LiveOne, RefusesWhatCannotBeAndChangesNothing) {
  LiveModel model({"lattice", 3}, 60, 3);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  const auto refused = [&](const ResultChange& change, const std::string& why) {
    const auto before = live_->current();
    const auto bytes = live_->log_bytes();
    const auto applied = live_->apply(change);
    ASSERT_FALSE(applied);
    EXPECT_NE(applied.error().where.find(why), std::string::npos) << applied.error().where;
    EXPECT_EQ(live_->current(), before);
    EXPECT_EQ(live_->log_bytes(), bytes);
  };
  std::vector<PointId> all, but_three;
  for (const auto& [id, p] : model.points()) {
    all.push_back(id);
    if (id.value >= 3) but_three.push_back(id);
  }
  refused({.remove = {PointId{0}, PointId{12345}}}, "there is no point 12345 to remove");
  refused({.remove = all}, "no points would be left");
  refused({.remove = but_three}, "lie in a plane");
  refused({.add = {{0, std::numeric_limits<double>::quiet_NaN(), 0}}}, "not finite");
  refused({.add = {{0, 0, 0}}, .rows = std::vector<std::byte>(4)}, "attributes");
  for (int k = 0; k < 5; ++k) step(model);  // what follows is right
}

TEST_F(LiveOne, NeverUsesARemovedIdAgain) {
  LiveModel model({"uniform", 2}, 30, 5);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  const auto one = live_->apply({.add = {{0.25, 0.5, 0}}});
  ASSERT_TRUE(one);
  const PointId id{one.value().first_new};
  ASSERT_TRUE(live_->apply({.remove = {id}}));
  open();
  ASSERT_NE(live_, nullptr);
  const auto two = live_->apply({.add = {{0.25, 0.5, 0}}});
  ASSERT_TRUE(two);
  EXPECT_EQ(two.value().first_new, id.value + 1);
  EXPECT_FALSE(live_->apply({.remove = {id}}));
}

// As a program changes it that does not know of the log.
Result<Updated> change_by_other(const fs::path& result) {
  Engine engine(1, std::uint64_t{1} << 30, kinds_of_stages());
  Progress progress;
  EngineStages stages(engine, {.threads = 1, .memory_bytes = std::uint64_t{1} << 30}, progress);
  return update_result(result, {.add = {{0.75, 0.5, 0}}}, {}, stages);
}

TEST_F(LiveOne, DoesNotLoseALogWhenTheResultIsChangedByOthers) {
  LiveModel model({"uniform", 2}, 30, 5);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  const auto in_memory = change_by_other(folder_);
  ASSERT_FALSE(in_memory);
  EXPECT_NE(in_memory.error().where.find("000001.log: another process has this log"), std::string::npos)
      << in_memory.error().where;
  ASSERT_TRUE(live_->apply({.add = {{0.25, 0.5, 0}}}));
  live_.reset();
  const auto unstored = change_by_other(folder_);
  ASSERT_FALSE(unstored);
  EXPECT_NE(unstored.error().where.find("000001.log: this log has changes that are not stored"), std::string::npos)
      << unstored.error().where;
  const fs::path log = folder_ / ".live" / "000001.log", away = scratch_.path() / "away";
  fs::rename(log, away);
  const auto updated = change_by_other(folder_);
  ASSERT_TRUE(updated) << updated.error().where;
  fs::rename(away, log);
  const auto lost = LiveResult::open(folder_, {});
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().where.find("000001.log: this log has changes of an older version"), std::string::npos)
      << lost.error().where;
}

// A process ends between the version that it stores and the removal of the log; then another program makes a version.
TEST_F(LiveOne, KnowsThatALogIsStoredAfterFurtherVersions) {
  LiveModel model({"uniform", 2}, 30, 5);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  ASSERT_TRUE(live_->apply({.add = {{0.25, 0.5, 0}}}));
  const fs::path log = folder_ / ".live" / "000001.log", copy = scratch_.path() / "copy",
                 kept = scratch_.path() / "log";
  const auto written = live_->write_to(copy);
  ASSERT_TRUE(written) << written.error().where;
  const Manifest stored = live_->source().manifest();
  live_.reset();
  {
    auto opened = LiveLog::open(
        folder_, stored, [](std::uint64_t) {}, [](std::uint64_t, const ResultChange&) { return success(); });
    ASSERT_TRUE(opened) << opened.error().where;
    ASSERT_TRUE(opened.value().note_version(2, *read_manifest(copy).value().digest));
  }
  fs::copy(log, kept);
  open();
  ASSERT_NE(live_, nullptr);
  ASSERT_TRUE(live_->checkpoint());
  live_.reset();
  fs::remove_all(folder_ / ".live");
  for (int k = 0; k < 2; ++k) {
    const auto updated = change_by_other(folder_);
    ASSERT_TRUE(updated) << updated.error().where;
  }
  fs::create_directory(folder_ / ".live");
  fs::copy(kept, log);
  open();
  ASSERT_NE(live_, nullptr);
  EXPECT_EQ(live_->current()->number(), 3u);  // one batch and two versions
  EXPECT_FALSE(fs::exists(log));
}

TEST_F(LiveOne, GivesNoNumberOfAVersionTwice) {
  LiveModel model({"uniform", 2}, 30, 5);
  model.store(folder_);
  std::uint64_t last = 0;
  for (int k = 0; k < 4; ++k) {
    open();
    ASSERT_NE(live_, nullptr);
    EXPECT_EQ(live_->current()->number(), last);
    for (int i = 0; i < 2; ++i) {
      const auto applied = live_->apply({.add = {{0.1 * k, 0.3 + i, 0}}});
      ASSERT_TRUE(applied) << applied.error().where;
      EXPECT_EQ(applied.value().version, ++last);
    }
    if (k % 2 == 1) {
      ASSERT_TRUE(live_->checkpoint());
      EXPECT_EQ(live_->state().stored, last);
      EXPECT_EQ(live_->state().added, 0u);
      EXPECT_EQ(live_->current()->number(), last);
    }
  }
  // Another program makes a version, which counts.
  ASSERT_TRUE(live_->checkpoint());
  live_.reset();
  const auto updated = change_by_other(folder_);
  ASSERT_TRUE(updated) << updated.error().where;
  open();
  ASSERT_NE(live_, nullptr);
  EXPECT_EQ(live_->current()->number(), last + 1);
}

TEST_F(LiveOne, RefusesDensitiesOfMasses) {
  StoredCloud cloud;
  cloud.dimension = 2;
  Bounds bounds;
  std::vector<Point> places;
  for (const LocalPoint& p : make_cloud("uniform", 2, 30, 1)) {
    cloud.points.push_back(p);
    places.push_back(p.at);
    bounds.add(p.at);
  }
  cloud.points_read = cloud.points.size();
  cloud.partition = Partition::build_tiles(PartitionKind::kdtree, 2, places, bounds, 3);
  cloud.schema = some_schema();
  cloud.store(folder_);
  ASSERT_TRUE(measure(folder_, {.density = true, .mass = "some"}, {}));
  const auto of_masses = LiveResult::open(folder_, {});
  ASSERT_FALSE(of_masses);
  EXPECT_NE(of_masses.error().where.find("computed column 'density_some'"), std::string::npos);
}

// The neighbours across all facets of all cells are the cells that share these facets.
TEST_F(LiveOne, StepsFromCellToCell) {
  for (const int dimension : {2, 3}) {
    folder_ = scratch_.path() / ("out" + std::to_string(dimension));
    LiveModel model({"lattice", dimension, 6}, 60, 9);
    model.store(folder_);
    open();
    ASSERT_NE(live_, nullptr);
    for (int k = 0; k < 6; ++k) step(model);
    const auto version = live_->current();
    for (const auto& [id, p] : model.points()) {
      const auto star = version->star(id);
      if (!star) continue;
      for (const LiveCell& cell : *star) {
        if (!cell.is_finite(dimension + 1)) continue;
        for (int corner = 0; corner <= dimension; ++corner) {
          const LiveCell next = version->across(cell, corner);
          for (int k = 0; k <= dimension; ++k)
            EXPECT_EQ(std::count(next.ids.begin(), next.ids.end(), cell.ids[k]), k == corner ? 0 : 1);
        }
      }
    }
  }
}

TEST_F(LiveOne, IsNotOpenedTwiceNorBeyondItsMemory) {
  LiveModel model({"uniform", 3}, 60, 5);
  model.store(folder_);
  const auto small = LiveResult::open(folder_, {.memory_bytes = 1000});
  ASSERT_FALSE(small);
  EXPECT_NE(small.error().where.find("need more than 1 MB"), std::string::npos) << small.error().where;
  open();
  const auto again = LiveResult::open(folder_, {});
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().where.find("another process has this log"), std::string::npos) << again.error().where;
}

// The areas of all cells of a stored result on a lattice, and their sums around vertices: no value is rounded.
void check_areas(const fs::path& folder) {
  const auto opened = TileSource::open(folder);
  ASSERT_TRUE(opened) << opened.error().where;
  const TileSource& source = opened.value();
  ASSERT_EQ(source.manifest().columns.size(), 2u);
  const auto at = [](const auto& bytes, std::size_t offset) {
    double value = 0;
    std::memcpy(&value, &bytes[offset], sizeof value);
    return value;
  };
  std::map<PointId, double> sums;
  std::map<std::pair<PointId, TileId>, double> stored_sums;
  double whole = 0;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const auto tile = source.read(i, {.cells = true, .rows = true, .cell_columns = true});
    ASSERT_TRUE(tile) << tile.error().where;
    const TileMesh& mesh = tile.value().mesh;
    const std::size_t width = row_bytes(source.manifest().schema);
    for (std::size_t v = 0; v < mesh.ids.size(); ++v)
      stored_sums[{mesh.ids[v], source.entry(i).tile}] = at(tile.value().rows, (v + 1) * width - sizeof(double));
    for (std::size_t c = 0; c < mesh.cell_ghost.size(); ++c) {
      const auto corner = [&](std::size_t k) { return static_cast<std::size_t>(mesh.cells[3 * c + k]); };
      const Point p = mesh.points[corner(0)], q = mesh.points[corner(1)], r = mesh.points[corner(2)];
      const double area = std::abs((q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x)) / 2;
      EXPECT_EQ(at(tile.value().cell_columns[0], c * sizeof(double)), area);
      if (mesh.cell_ghost[c] == 0) whole += area;
      for (std::size_t k = 0; k < 3 && mesh.cell_ghost[c] == 0; ++k) sums[mesh.ids[corner(k)]] += area;
    }
  }
  EXPECT_EQ(source.manifest().columns[0].total, whole);
  for (const auto& [of, sum] : stored_sums) EXPECT_EQ(sum, sums[of.first]) << "of point " << to_string(of.first);
}

class LiveColumns : public Live {};

TEST_P(LiveColumns, AreMadeAgainWhereTilesHaveChanged) {
  LiveModel model(GetParam(), 120, 3);
  if (GetParam().grows) tile_points_ = 12;  // tiles are split
  const std::size_t tiles = GetParam().tiles;
  model.store(folder_);
  const auto measured = measure(folder_, {.volume = true}, {});
  ASSERT_TRUE(measured) << measured.error().where;
  check_areas(folder_);
  open(2);
  ASSERT_NE(live_, nullptr);
  for (int k = 0; k < 12; ++k) {
    step(model);
    if (k % 3 != 2) continue;
    const fs::path copy = scratch_.path() / ("copy" + std::to_string(k));
    const auto written = live_->write_to(copy);
    ASSERT_TRUE(written) << written.error().where;
    check_areas(copy);
    const Status made = live_->checkpoint();
    ASSERT_TRUE(made) << made.error().where;
    check_areas(folder_);
    for (const fs::path& result : {copy, folder_}) {
      const auto proof = verify(result, {}, {});
      EXPECT_TRUE(proof) << proof.error().where;
    }
    if (HasFailure()) return;
  }
  open();
  ASSERT_NE(live_, nullptr);
  EXPECT_EQ(model.compare(*live_->current()), "");
  EXPECT_EQ(live_->current()->tiles().size() > tiles, GetParam().grows);
}

INSTANTIATE_TEST_SUITE_P(Tiles, LiveColumns,
                         ::testing::Values(LiveCase{"lattice", 2, 9},
                                           LiveCase{.kind = "lattice", .dimension = 2, .tiles = 9, .grows = true}),
                         [](const auto& info) { return info.param.grows ? "Split" : "Same"; });

// A tile sees only a part of the hull. It must not wake those whose points it takes for neighbours of a far point.
TEST_F(LiveOne, WakesFewTilesWhenAVertexOfTheHullGoes) {
  LiveModel model({"uniform", 2, 200}, 4500, 9);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  for (int k = 0; k < 4; ++k) {
    const auto& points = model.points();
    const auto by_place = [](const auto& a, const auto& b) { return a.second < b.second; };
    const auto [least, greatest] = std::minmax_element(points.begin(), points.end(), by_place);
    const ResultChange change{.add = {}, .rows = {}, .remove = {k % 2 == 0 ? least->first : greatest->first}};
    const auto applied = live_->apply(change);
    ASSERT_TRUE(applied) << applied.error().where;
    EXPECT_LT(applied.value().awake, 50u);
    model.apply(change);
    EXPECT_EQ(model.compare(*live_->current()), "");
  }
}

TEST_F(LiveOne, CountsTheTilesOfOlderVersionsAsLongAsTheyAreRead) {
  LiveModel model({"uniform", 2, 1}, 300, 5);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  const std::size_t one = live_->current()->memory();
  live_.reset();
  auto opened = LiveResult::open(folder_, {.memory_bytes = 4 * one});
  ASSERT_TRUE(opened) << opened.error().where;
  live_ = std::move(opened).value();
  const auto add = [&](int k) { return live_->apply({.add = {{0.5, 0.25 + 0.001 * k, 0}}}); };
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(add(k));  // nobody has the older versions
  std::vector<std::shared_ptr<const LiveVersion>> held{live_->current()};
  std::string refused;
  for (int k = 20; k < 40 && refused.empty(); ++k) {
    const auto applied = add(k);
    if (applied) {
      held.push_back(live_->current());
    } else {
      refused = applied.error().where;
    }
  }
  EXPECT_NE(refused.find("older versions that are still read"), std::string::npos) << refused;
  EXPECT_LE(held.size(), 5u);
  held.clear();
  EXPECT_TRUE(add(41));
}

// Differences and squares of their coordinates overflow.
TEST_F(LiveOne, HasPointsAsFarAwayAsNumbersReach) {
  constexpr double far = 1.5e308;
  for (const int dimension : {2, 3}) {
    folder_ = scratch_.path() / ("far" + std::to_string(dimension));
    LiveModel model({"lattice", dimension, 7}, 60, 3);
    model.store(folder_);
    open();
    ASSERT_NE(live_, nullptr);
    const double up = dimension == 3 ? far : 0;
    for (const std::vector<Point>& add : {std::vector<Point>{{far, -far, up}, {-far, far, -up}, {1e-300, far, 0}},
                                          std::vector<Point>{{far, far, up}, {-far, -far, -up}, {2.5, 1e200, 0}}}) {
      const ResultChange change{.add = add};
      const auto applied = live_->apply(change);
      ASSERT_TRUE(applied) << applied.error().where;
      model.apply(change);
      EXPECT_EQ(model.compare(*live_->current()), "");
    }
    const auto equal = live_->apply({.add = {{far, far, up}}}, EqualToNew::go);
    ASSERT_TRUE(equal) << equal.error().where;
    EXPECT_EQ(equal.value().removed, 1u);
    open();
    ASSERT_NE(live_, nullptr);
    ASSERT_TRUE(live_->checkpoint());
    EXPECT_TRUE(verify(folder_, {}, {}));
  }
}

// A reader asks the stars of neighbours: all of them must have the cells of the first one.
TEST_F(LiveOne, ReadersSeeWholeVersionsBesideWrites) {
  LiveModel model({"uniform", 2, 9}, 300, 7);
  model.store(folder_);
  open();
  ASSERT_NE(live_, nullptr);
  std::atomic<bool> done{false};
  std::atomic<int> wrong{0}, asked{0};
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
  for (int k = 0; k < 200; ++k) {
    const ResultChange change = model.next();
    if (live_->apply(change)) {
      model.apply(change);
    } else {
      model.skip();
    }
  }
  done = true;
  one.join();
  two.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(model.compare(*live_->current()), "");
}

}  // namespace
}  // namespace tessera::testing

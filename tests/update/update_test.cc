#include "src/delaunay/update/update.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/delaunay/update/select_points.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "src/job/engine_steps.h"
#include "src/result/measure/hull_change.h"
#include "src/result/measure/measure.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "tests/update/update_testing.h"

namespace tessera::testing {
namespace {

// Of 400 tiles. A change at the hull concerns as few tiles as any other.
class UpdateAtTheHull : public Update, public ::testing::WithParamInterface<int> {
 protected:
  void SetUp() override { make({"uniform", GetParam(), 400, PartitionKind::kdtree, TileKind::cells}, 9000, 5, false); }
  // Vertices of one edge of the hull, by different owners.
  std::vector<PointId> edge_of_hull() const {
    const auto source = TileSource::open(now()).value();
    for (std::size_t i = 0; i < source.tiles(); ++i) {
      const TileMesh mesh = source.read(i, {.cells = true}).value().mesh;
      const auto corners = static_cast<std::size_t>(mesh.dimension) + 1;
      const auto on_hull = [&](std::int32_t v) {  // near enough: on the side of the least x
        return mesh.points[static_cast<std::size_t>(v)].x < source.manifest().bounds.lo.x + 0.02;
      };
      for (std::size_t at = 0; at < mesh.cells.size(); at += corners) {
        const std::int32_t a = mesh.cells[at], b = mesh.cells[at + 1];
        if (on_hull(a) && on_hull(b) &&
            mesh.owners[static_cast<std::size_t>(a)] != mesh.owners[static_cast<std::size_t>(b)])
          return {mesh.ids[static_cast<std::size_t>(a)], mesh.ids[static_cast<std::size_t>(b)]};
      }
    }
    return {};
  }
};

TEST_P(UpdateAtTheHull, ReadsOnlyTilesThatChangeWhenOneVertexGoes) {
  for (const bool high : {false, true}) {
    const auto by_x = [](const auto& a, const auto& b) { return a.at.x < b.at.x; };
    const auto [least, greatest] = std::minmax_element(cloud_.points.begin(), cloud_.points.end(), by_x);
    const Updated updated = update(change({high ? greatest->id : least->id}, {}));
    EXPECT_EQ(updated.begun, 0u);
    EXPECT_EQ(updated.exchange.sent, 0u);
    EXPECT_EQ(updated.awake, updated.written);
    EXPECT_LT(updated.awake, 40u);
    expect_as_from_scratch();
  }
}

TEST_P(UpdateAtTheHull, ReadsFewTilesWhenVerticesOfSeveralTilesGo) {
  const std::vector<PointId> edge = edge_of_hull();
  ASSERT_EQ(edge.size(), 2u);
  const Updated updated = update(change(edge, {}));
  EXPECT_GT(updated.begun, 1u);
  EXPECT_LT(updated.awake, 100u);
  expect_as_from_scratch();
}

TEST_P(UpdateAtTheHull, ReadsFewTilesBesideThoseThatChangeForAPointFarAway) {
  const Point far = GetParam() == 2 ? Point{0.5, 40, 0} : Point{0.5, 0.5, 40};
  const PointId id{cloud_.points_read};
  const Updated added = update(change({}, {far}));
  EXPECT_LE(added.awake, added.written * 5 / 4);
  expect_as_from_scratch();
  const Updated removed = update(change({id}, {}));
  EXPECT_EQ(removed.exchange.sent, 0u);
  EXPECT_EQ(removed.awake, removed.written);
  EXPECT_LE(removed.awake, added.written + 1);
  expect_as_from_scratch();
}

INSTANTIATE_TEST_SUITE_P(Dimensions, UpdateAtTheHull, ::testing::Values(2, 3));

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
  EXPECT_FALSE(dry.value().estimated);
}

TEST_F(Update, ThatIsDryAndLargeIsEstimatedByTheTilesOfItsPointsAndThoseThatTouchThem) {
  make(planar, 6000, seed, true);
  const ResultChange wanted = change({cloud_.points[17].id, cloud_.points[18].id}, {{0.5, 0.5, 0}});
  const auto dry = update_here(now(), wanted, {.threads = 2, .dry_run = true, .dry_points = 100});
  ASSERT_TRUE(dry) << dry.error().where;
  EXPECT_TRUE(dry.value().estimated);
  const Updated updated = update(wanted);
  EXPECT_EQ(dry.value().removed, 2u);
  EXPECT_GE(dry.value().awake, updated.awake);
  EXPECT_GE(dry.value().begun, 1u);
  EXPECT_LT(dry.value().awake, 20u);
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

TEST_P(UpdateBy, OfAResultWithoutTheAttributesOfDuplicatesRemovesAVertexTogetherWithItsDuplicatesAlone) {
  make(usual, 300, seed, true);
  cloud_.points.push_back({cloud_.points[40].at, PointId{cloud_.points_read++}});
  cloud_.duplicate_rows = false;
  fs::remove_all(now());
  cloud_.store(now());
  update(change({PointId{50}}, {cloud_.points[41].at}));
  expect_as_from_scratch();
  EXPECT_NE(refusal(change({PointId{40}}, {})).find("point 40 cannot be removed alone"), std::string::npos);
  update(change({PointId{40}, PointId{cloud_.points_read - 2}}, {}));
  cloud_.duplicate_rows = true;  // those that are left came with the change
  cloud_.store(folder_.path() / "with");
  const Manifest manifest = read_manifest(now()).value();
  EXPECT_EQ(manifest.duplicate_rows_xxh3, 0u);
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

// Columns of a changed result are those of its points triangulated from scratch.
class UpdateOfColumns : public Update, public ::testing::WithParamInterface<Case> {
 protected:
  using Values = std::map<std::pair<std::string, std::vector<PointId>>, std::vector<std::byte>>;

  static void measure_all(const fs::path& out) {
    const std::uint64_t memory_bytes = std::uint64_t{1} << 30;
    for (const MeasureOptions& options :
         {MeasureOptions{.volume = true, .quality = true, .voronoi = true, .density = true},
          MeasureOptions{.density = true, .mass = "some"}, MeasureOptions{.density = true, .mass = "density"}}) {
      MeasureOptions with_memory = options;
      with_memory.memory_bytes = memory_bytes;
      with_memory.threads = 2;
      const auto measured = measure(out, with_memory, {});
      ASSERT_TRUE(measured) << measured.error().where;
    }
  }

  // By column, and by the vertex or the vertices of the cell. All files that have it must agree.
  static Values columns_of(const fs::path& out) {
    Values values;
    const auto source = TileSource::open(out).value();
    const auto& columns = source.manifest().columns;
    for (std::size_t i = 0; i < source.tiles(); ++i) {
      const auto read = source.read(i, {.cells = true, .rows = true, .cell_columns = true});
      EXPECT_TRUE(read) << (read ? "" : read.error().where);
      if (!read) return values;
      const StoredTile& tile = read.value();
      const TileMesh& mesh = tile.mesh;
      const auto note = [&](const ResultColumn& column, std::vector<PointId> of, const std::byte* from) {
        std::sort(of.begin(), of.end());
        std::vector<std::byte> value(from, from + size_of(column.type));
        const auto [known, first] = values.try_emplace({column.name, std::move(of)}, value);
        EXPECT_EQ(known->second, value) << column.name << " in tile " << to_string(source.entry(i).tile);
      };
      std::size_t of_cells = 0;
      for (const ResultColumn& column : columns) {
        const auto in_row = column_of(tile.schema, column.name);
        const auto corners = static_cast<std::ptrdiff_t>(mesh.dimension) + 1;
        for (std::size_t v = 0; v < mesh.ids.size() && !column.of_cells; ++v)
          note(column, {mesh.ids[v]}, &tile.rows[v * row_bytes(tile.schema) + in_row->offset]);
        for (std::size_t c = 0; c < mesh.cell_ghost.size() && column.of_cells; ++c) {
          std::vector<PointId> ids;
          for (std::ptrdiff_t k = 0; k < corners; ++k)
            ids.push_back(mesh.ids[static_cast<std::size_t>(
                mesh.cells[c * static_cast<std::size_t>(corners) + static_cast<std::size_t>(k)])]);
          note(column, std::move(ids), &tile.cell_columns[of_cells][c * size_of(column.type)]);
        }
        of_cells += column.of_cells ? 1 : 0;
      }
    }
    return values;
  }

  void expect_columns_as_from_scratch() const {
    const test::TemporaryFolder scratch;
    const fs::path out = scratch.path() / "out";
    cloud_.store(out);
    measure_all(out);
    const Manifest expected = read_manifest(out).value(), got = read_manifest(now()).value();
    EXPECT_EQ(got.digest, expected.digest);
    ASSERT_EQ(got.columns.size(), expected.columns.size());
    for (std::size_t c = 0; c < got.columns.size(); ++c) {
      EXPECT_EQ(got.columns[c].name, expected.columns[c].name);
      EXPECT_EQ(got.columns[c].total, expected.columns[c].total) << got.columns[c].name;
    }
    EXPECT_TRUE(columns_of(now()) == columns_of(out));
    const auto verified = verify(now(), {}, {});
    EXPECT_TRUE(verified) << verified.error().where;
  }

  // Whether the hull may have changed with the last change.
  bool hull_may_have_changed() const {
    const auto before = TileSource::open(folder_.path() / ("r" + std::to_string(number_ - 1))).value();
    const auto after = TileSource::open(now()).value();
    HullChange change(before, {});
    for (std::size_t i = 0; i < after.tiles(); ++i) {
      EXPECT_TRUE(change.look_at(after.entry(i).tile, after.read(i, {}).value().mesh));
    }
    for (std::size_t i = 0; i < before.tiles(); ++i) {
      if (after.find(before.entry(i).tile)) continue;
      EXPECT_TRUE(change.look_at_gone(before.entry(i).tile));
    }
    return change.is_possible();
  }

  const LocalPoint& nearest_to(const Point& place) const {
    const auto far = [&](const LocalPoint& p) {
      return std::hypot(p.at.x - place.x, p.at.y - place.y, p.at.z - place.z);
    };
    return *std::min_element(cloud_.points.begin(), cloud_.points.end(),
                             [&](const auto& a, const auto& b) { return far(a) < far(b); });
  }
};

TEST_P(UpdateOfColumns, HaveTheBitsOfThoseFromScratch) {
  make(GetParam(), 330, 21, true);
  measure_all(now());
  const bool flat = GetParam().dimension == 2;
  const Point middle{0.5, 0.5, flat ? 0 : 0.5}, beside{0.4, 0.6, flat ? 0 : 0.5}, outside{-3, 0.25, flat ? 0 : 4.0};
  const LocalPoint inner = nearest_to(middle), other = nearest_to(beside), corner = nearest_to({-9, 0.3, 0});

  // Only the number of points at a place changes: no cell, but densities, also in tiles beside.
  const Updated doubled = update(change({}, {inner.at, inner.at, other.at}));
  EXPECT_EQ(doubled.written, 0u);
  EXPECT_EQ(doubled.duplicates, 3u);
  expect_columns_as_from_scratch();
  EXPECT_FALSE(hull_may_have_changed());
  const PointId second{cloud_.points_read - 3};
  update(change({second}, {}));
  expect_columns_as_from_scratch();
  // A duplicate takes the place of its vertex, and another vertex goes with its duplicate.
  update(change({inner.id, other.id, PointId{cloud_.points_read - 1}}, {}));
  expect_columns_as_from_scratch();

  update(change({nearest_to(middle).id}, {{0.51, 0.47, flat ? 0 : 0.49}}));
  expect_columns_as_from_scratch();
  EXPECT_FALSE(hull_may_have_changed());
  update(change({corner.id}, {}));
  expect_columns_as_from_scratch();
  EXPECT_TRUE(hull_may_have_changed());
  update(change({}, {outside, outside}));
  expect_columns_as_from_scratch();
  EXPECT_TRUE(hull_may_have_changed());

  std::vector<PointId> one_tile{PointId{cloud_.points_read - 1}};
  for (const LocalPoint& p : cloud_.points) {
    if (cloud_.partition.tile_of(p.at) == cloud_.partition.tile_of(middle)) one_tile.push_back(p.id);
  }
  update(change(one_tile, {middle}));
  expect_columns_as_from_scratch();
  way_ = UpdateWay::anew;
  update(change({nearest_to(beside).id}, {middle}));
  expect_columns_as_from_scratch();
}

INSTANTIATE_TEST_SUITE_P(Cases, UpdateOfColumns,
                         ::testing::Values(Case{"uniform", 2, 9, PartitionKind::kdtree, TileKind::cells},
                                           Case{"uniform", 2, 12, PartitionKind::grid, TileKind::points, true},
                                           Case{"uniform", 3, 8, PartitionKind::kdtree, TileKind::points},
                                           Case{"uniform", 3, 5, PartitionKind::octree, TileKind::cells, true},
                                           Case{"uniform", 3, 4, PartitionKind::random, TileKind::cells}),
                         [](const auto& info) {
                           return "In" + std::to_string(info.param.dimension) + "DOf" +
                                  std::to_string(info.param.tiles);
                         });

// A mass of the new points is not finite.
TEST_F(Update, RefusesAMassThatIsNotFiniteAndNamesTheVertex) {
  make({"uniform", 2, 4, PartitionKind::kdtree, TileKind::cells}, 120, 4, false);
  cloud_.schema = {{"mass", AttributeType::f64}};
  cloud_.row_of = [](PointId id) {
    const double mass = id.value == 80 ? std::numeric_limits<double>::infinity() : 1.5;
    std::vector<std::byte> row(sizeof mass);
    std::memcpy(row.data(), &mass, sizeof mass);
    return row;
  };
  fs::remove_all(now());
  cloud_.store(now());
  const auto measured = measure(now(), {.density = true, .mass = "mass", .threads = 1}, {});
  ASSERT_TRUE(measured) << measured.error().where;
  const std::string said = refusal(change({}, {{0.5, 0.51, 0}}));
  EXPECT_EQ(said, now().string() + ": the attribute 'mass' of vertex 80 is inf, but a mass must be finite");
}

}  // namespace
}  // namespace tessera::testing

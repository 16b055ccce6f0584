#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "src/result/measure/measure.h"
#include "src/result/tile_source.h"
#include "src/result/verify/verify.h"
#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

// What is stored: of each cell, by its vertices' ids, and of each vertex.
struct Found {
  std::map<std::vector<PointId>, double> cells;
  std::map<PointId, double> vertices;
  double total = 0;
  bool same = true;  // in all tiles that have it
  friend bool operator==(const Found&, const Found&) = default;
};

double double_at(const std::vector<std::byte>& bytes, std::size_t i) {
  double value = 0;
  std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
  return value;
}

Found read(const fs::path& out) {
  Found found;
  const auto source = TileSource::open(out).value();
  const std::size_t corners = static_cast<std::size_t>(source.manifest().dimension) + 1;
  found.total = source.manifest().columns.front().total.value();
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const auto tile = source.read(i, {.rows = true, .cell_columns = true}).value();
    for (std::size_t cell = 0; cell < tile.mesh.cell_ghost.size(); ++cell) {
      std::vector<PointId> ids;
      for (std::size_t k = 0; k < corners; ++k)
        ids.push_back(tile.mesh.ids[static_cast<std::size_t>(tile.mesh.cells[cell * corners + k])]);
      std::sort(ids.begin(), ids.end());
      const double value = double_at(tile.cell_columns.front(), cell);
      found.same = found.same && found.cells.try_emplace(ids, value).first->second == value;
    }
    for (std::size_t v = 0; v < tile.mesh.ids.size(); ++v) {
      const double value = double_at(tile.rows, v);
      found.same = found.same && found.vertices.try_emplace(tile.mesh.ids[v], value).first->second == value;
    }
  }
  return found;
}

Measured measured(const fs::path& out, unsigned threads = 1) {
  const auto done = measure(out, {.volume = true, .memory_bytes = std::uint64_t{1} << 30, .threads = threads}, {});
  EXPECT_TRUE(done) << done.error().where;
  return done ? done.value() : Measured{};
}

class MeasureSample : public testing::TestWithParam<std::tuple<Shape, int>> {
 protected:
  int dimension() const { return std::get<1>(GetParam()); }
  const std::vector<Point> points_ = sample_points(std::get<0>(GetParam()), dimension(), 400);
};

INSTANTIATE_TEST_SUITE_P(Shapes, MeasureSample,
                         testing::Combine(testing::Values(Shape::uniform, Shape::lattice, Shape::sphere,
                                                          Shape::terrain),
                                          testing::Values(2, 3)));

TEST_P(MeasureSample, HasTheSameBitsForAnyTilesThreadsAndOrder) {
  std::optional<Found> first;
  for (const std::uint32_t tiles : {1u, 7u, 50u}) {
    for (const unsigned threads : {1u, 2u, 4u}) {
      for (const bool random : {false, true}) {
        const TemporaryFolder folder;
        const auto meshes =
            random ? sample_tiles(points_, dimension(), tiles,
                                  [&](std::size_t i) { return static_cast<std::uint32_t>(i * 31 % tiles); })
                   : sample_tiles(points_, dimension(), tiles);
        store_sample(folder.path() / "out", meshes, {.neighbors = threads != 2});
        const Measured done = measured(folder.path() / "out", threads);
        EXPECT_TRUE(done.made);
        const Found found = read(folder.path() / "out");
        EXPECT_TRUE(found.same);
        EXPECT_EQ(found.total, done.total);
        if (!first) first = found;
        EXPECT_EQ(found, *first) << tiles << " tiles, " << threads << " threads";
      }
    }
  }
}

// Each cell, by its vertices' ids, with the values of all its columns.
std::map<std::vector<PointId>, std::vector<double>> shapes(const fs::path& out) {
  std::map<std::vector<PointId>, std::vector<double>> found;
  const auto source = TileSource::open(out).value();
  const std::size_t corners = static_cast<std::size_t>(source.manifest().dimension) + 1;
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const auto tile = source.read(i, {.rows = true, .cell_columns = true}).value();
    for (std::size_t cell = 0; cell < tile.mesh.cell_ghost.size(); ++cell) {
      std::vector<PointId> ids;
      for (std::size_t k = 0; k < corners; ++k)
        ids.push_back(tile.mesh.ids[static_cast<std::size_t>(tile.mesh.cells[cell * corners + k])]);
      std::sort(ids.begin(), ids.end());
      std::vector<double> values;
      for (const auto& column : tile.cell_columns) values.push_back(double_at(column, cell));
      EXPECT_EQ(found.try_emplace(ids, values).first->second, values);
    }
  }
  return found;
}

TEST_P(MeasureSample, ShapesHaveTheSameBitsForAnyTilesAndBounds) {
  std::optional<std::map<std::vector<PointId>, std::vector<double>>> first;
  for (const std::uint32_t tiles : {1u, 7u, 50u}) {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    store_sample(out, sample_tiles(points_, dimension(), tiles));
    const auto done = measure(out, {.quality = true, .memory_bytes = std::uint64_t{1} << 30, .threads = 2}, {});
    ASSERT_TRUE(done) << done.error().where;
    EXPECT_FALSE(done.value().total);
    const auto found = shapes(out);
    if (!first) first = found;
    EXPECT_EQ(found, *first);
    for (const auto& [ids, values] : found) {
      ASSERT_EQ(values.size(), 4u);
      EXPECT_TRUE(values[0] > 0 && values[0] <= 1) << values[0];
      EXPECT_TRUE(values[1] > 0 && values[1] <= values[2] && values[2] < 180) << values[1] << " " << values[2];
      EXPECT_GT(values[3], 0);
    }
  }
}

TEST_P(MeasureSample, HasTheSameBitsWhenTilesAreKeptAsPoints) {
  const auto meshes = sample_tiles(points_, dimension(), 7);
  std::optional<Found> first;
  for (const std::uint32_t of_points : {0u, 3u, 7u}) {  // tiles
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    store_sample(out, meshes, {.schema = {}}, {}, {},
                 [&](TileId tile) { return tile.value < of_points ? TileKind::points : TileKind::cells; });
    const Measured done = measured(out, 2);
    const Found found = read(out);
    EXPECT_TRUE(found.same);
    EXPECT_EQ(found.total, done.total);
    if (!first) first = found;
    EXPECT_EQ(found, *first) << of_points;
    const auto proof = verify(out, {}, {});
    EXPECT_TRUE(proof) << proof.error().where;
  }
}

TEST_P(MeasureSample, AddsUpToTheWholeAndToStars) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  store_sample(out, sample_tiles(points_, dimension(), 5));
  measured(out, 2);
  const Found found = read(out);
  std::map<PointId, double> stars;
  double whole = 0;
  for (const auto& [ids, value] : found.cells) {
    EXPECT_GT(value, 0);
    whole += value;
    for (const PointId id : ids) stars[id] += value;
  }
  EXPECT_NEAR(whole / found.total, 1, 1e-12);
  ASSERT_EQ(stars.size(), found.vertices.size());
  for (const auto& [id, value] : stars) EXPECT_NEAR(found.vertices.at(id) / value, 1, 1e-12);
  const auto proof = verify(out, {}, {});
  EXPECT_TRUE(proof) << proof.error().where;
}

TEST(Measure, OfACubeOfLatticePointsIsItsVolume) {
  const TemporaryFolder folder;
  std::vector<Point> points;
  for (int i = 0; i < 6 * 6 * 6; ++i)
    points.push_back({static_cast<double>(i % 6), static_cast<double>(i / 6 % 6), static_cast<double>(i / 36)});
  store_sample(folder.path() / "out", sample_tiles(points, 3, 4));
  EXPECT_EQ(measured(folder.path() / "out").total, 125);
}

TEST(Measure, TwiceFindsTheColumnsThereAndGivesTheRoomBack) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  store_sample(out, sample_tiles(sample_points(Shape::uniform, 2, 200), 2, 3));
  const Measured first = measured(out), second = measured(out);
  EXPECT_TRUE(first.made);
  EXPECT_FALSE(second.made);
  EXPECT_EQ(second.total, first.total);
  EXPECT_EQ(second.version, 2u);
  EXPECT_FALSE(fs::exists(out / ".versions" / "000001.json"));
  EXPECT_FALSE(fs::exists(out / "tiles" / "000000.vtu"));
  EXPECT_TRUE(fs::exists(out / "tiles" / "000000-2.vtu"));
}

TEST(Measure, WhatADoubleDoesNotHoldIsInfiniteAndTold) {
  const TemporaryFolder folder;
  auto points = sample_points(Shape::uniform, 3, 40);
  for (Point& p : points) p = {p.x * 1e120, p.y * 1e120, p.z * 1e120};
  store_sample(folder.path() / "out", sample_tiles(points, 3, 2));
  const Measured done = measured(folder.path() / "out");
  EXPECT_GT(done.infinite, 0u);
  EXPECT_EQ(done.total, std::numeric_limits<double>::infinity());
  EXPECT_NE(done.note.find("beyond what a double holds"), std::string::npos);
  EXPECT_EQ(read(folder.path() / "out").total, done.total);
}

TEST(Measure, ANameThatIsTakenIsTold) {
  const TemporaryFolder folder;
  StoreOptions options;
  options.schema = {{"star_area", AttributeType::f64}};
  store_sample(folder.path() / "out", sample_tiles(sample_points(Shape::uniform, 2, 50), 2, 2), options);
  const auto done = measure(folder.path() / "out", {.volume = true}, {});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::usage);
  EXPECT_NE(done.error().where.find("an attribute 'star_area' already"), std::string::npos) << done.error().where;
}

TEST(Measure, ACellThatIsTurnedIsDamage) {
  const TemporaryFolder folder;
  for (const int dimension : {2, 3}) {
    auto meshes = sample_tiles(sample_points(Shape::uniform, dimension, 60), dimension, 1);
    const auto second = static_cast<std::size_t>(dimension) + 1;
    std::swap(meshes[0].cells[second], meshes[0].cells[second + 1]);
    const fs::path out = folder.path() / std::to_string(dimension);
    store_sample(out, meshes);
    for (const MeasureOptions& options :
         {MeasureOptions{.volume = true}, MeasureOptions{.quality = true}, MeasureOptions{.voronoi = true}}) {
      const auto done = measure(out, options, {});
      ASSERT_FALSE(done);
      EXPECT_EQ(done.error().code, Errc::corrupt);
      EXPECT_NE(done.error().where.find("000000.vtu: cell 1 is not positively oriented"), std::string::npos)
          << done.error().where;
    }
  }
}

TEST(Measure, EndsWhenItIsStoppedAndLeavesTheOldVersion) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  store_sample(out, sample_tiles(sample_points(Shape::uniform, 2, 200), 2, 3));
  std::stop_source stop;
  stop.request_stop();
  const auto done = measure(out, {.volume = true}, stop.get_token());
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::interrupted);
  EXPECT_EQ(TileSource::open(out).value().manifest().version, 1u);
  EXPECT_FALSE(fs::exists(out / ".versions"));
}

}  // namespace
}  // namespace tessera::test

// Zones of results whose columns are made up: many equal densities, and tiles that no partition of space gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/attribute_value.h"
#include "src/result/new_version.h"
#include "src/result/voids/voids.h"
#include "tests/store/sample_result.h"

namespace tessera::voids {
namespace {

namespace fs = std::filesystem;
using test::sample_points;
using test::sample_tiles;
using test::Shape;
using test::store_sample;
using test::TemporaryFolder;

// The value of a vertex in a tile.
using Values = std::function<double(std::size_t tile, const TileMesh& mesh, std::size_t vertex)>;

void give_column(const fs::path& out, const std::string& name, const Values& value) {
  auto next = NewVersion::begin(out).value();
  const ResultColumn column{
      .name = name, .of_cells = false, .type = AttributeType::f64, .unit = "", .command = {}, .software_version = {}};
  for (std::size_t i = 0; i < next->source().tiles(); ++i) {
    const TileMesh mesh = next->source().read(i, {}).value().mesh;
    std::vector<double> values;
    for (std::size_t v = 0; v < mesh.ids.size(); ++v) values.push_back(value(i, mesh, v));
    const store::ColumnValues one{false, {name, AttributeType::f64}, std::as_bytes(std::span(values))};
    ASSERT_TRUE(next->add_columns(i, std::span(&one, 1), {}));
  }
  ASSERT_TRUE(next->commit({column}));
}

// The zone of each vertex by the definition; -1: none.
std::map<PointId, std::int64_t> zones_by_definition(const TileMesh& mesh,
                                                    const std::function<double(PointId)>& volume) {
  std::map<PointId, std::set<PointId>> near;
  const std::size_t corners = static_cast<std::size_t>(mesh.dimension) + 1;
  for (std::size_t at = 0; at < mesh.cells.size(); at += corners)
    for (std::size_t i = 0; i < corners; ++i)
      for (std::size_t j = 0; j < corners; ++j)
        near[mesh.ids[static_cast<std::size_t>(mesh.cells[at + i])]].insert(
            mesh.ids[static_cast<std::size_t>(mesh.cells[at + j])]);  // itself, too
  const auto lowest = [&](PointId id) {
    return *std::min_element(near[id].begin(), near[id].end(), [&](PointId a, PointId b) {
      const double of_a = std::isinf(volume(a)) ? -1 : volume(a), of_b = std::isinf(volume(b)) ? -1 : volume(b);
      return of_a > of_b || (of_a == of_b && a < b);
    });
  };
  std::map<PointId, std::int64_t> zones;
  for (const PointId id : mesh.ids) {
    PointId end = id;
    while (lowest(end) != end && !std::isinf(volume(id))) end = lowest(end);
    zones[id] = std::isinf(volume(id)) ? -1 : static_cast<std::int64_t>(end.value);
  }
  return zones;
}

// As stored in all tiles; nothing when two tiles differ.
std::optional<std::map<PointId, std::int64_t>> stored_zones(const fs::path& out) {
  std::map<PointId, std::int64_t> zones;
  const auto source = TileSource::open(out).value();
  const auto column = column_of(source.manifest().schema, "zone").value();
  const std::size_t row = row_bytes(source.manifest().schema);
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    const auto tile = source.read(i, {.cells = false, .rows = true}).value();
    for (std::size_t v = 0; v < tile.mesh.ids.size(); ++v) {
      std::int64_t zone = 0;
      std::memcpy(&zone, &tile.rows[v * row + column.offset], sizeof zone);
      if (zones.try_emplace(tile.mesh.ids[v], zone).first->second != zone) return std::nullopt;
    }
  }
  return zones;
}

double made_up_volume(PointId id) {
  const std::uint64_t mixed = (id.value + 1) * 0x9E3779B97F4A7C15u >> 40;
  return mixed % 11 == 0 ? std::numeric_limits<double>::infinity() : static_cast<double>(1 + mixed % 6);
}

std::string name_of_volume(int dimension) { return dimension == 2 ? "voronoi_area" : "voronoi_volume"; }

VoidsOptions options_of(unsigned threads, std::uint64_t memory_bytes = std::uint64_t{1} << 30) {
  return {.memory_bytes = memory_bytes, .threads = threads};
}

TEST(FindVoids, ZonesAreThoseOfTheDefinitionWhateverOwnsThePoints) {
  for (const int dimension : {2, 3}) {
    const auto points = sample_points(Shape::uniform, dimension, 400);
    const auto wanted = zones_by_definition(sample_tiles(points, dimension, 1).front(), made_up_volume);
    std::set<std::string> tables;
    for (const std::uint32_t tiles : {1u, 7u, 50u, 399u}) {
      for (const bool scattered : {false, true}) {
        const TemporaryFolder folder;
        const fs::path out = folder.path() / "out";
        store_sample(out, scattered
                              ? sample_tiles(points, dimension, tiles,
                                             [&](std::size_t i) { return static_cast<std::uint32_t>(i * 31 % tiles); })
                              : sample_tiles(points, dimension, tiles));
        give_column(out, name_of_volume(dimension),
                    [](std::size_t, const TileMesh& mesh, std::size_t v) { return made_up_volume(mesh.ids[v]); });
        const auto found = find_voids(out, options_of(1 + tiles % 3, scattered ? 1 : std::uint64_t{1} << 30), {});
        ASSERT_TRUE(found) << found.error().where;
        EXPECT_EQ(stored_zones(out), wanted) << dimension << "D, " << tiles << " tiles, scattered " << scattered;
        std::string table;
        for (const VoidRow& row : found.value().table.rows)
          table += to_string(row.core) + " " + std::to_string(row.points) + " " + std::to_string(row.zones) + " " +
                   std::to_string(row.contrast) + " " + std::to_string(row.parent) + "\n";
        tables.insert(table);
      }
    }
    EXPECT_EQ(tables.size(), 1u);
  }
}

std::string failure(const fs::path& out, Errc code, VoidsOptions options = options_of(2), std::stop_token stop = {}) {
  const auto found = find_voids(out, options, std::move(stop));
  if (found) return "there is no error";
  EXPECT_EQ(found.error().code, code) << found.error().where;
  EXPECT_TRUE(TileSource::open(out).value().manifest().columns.size() < 2);
  return found.error().where;
}

class Contradictions : public testing::Test {
 protected:
  // `wrong` is said of the first foreign vertex of tile 2, instead of its volume.
  void store(double wrong) {
    store_sample(out_, sample_tiles(sample_points(Shape::uniform, 2, 300), 2, 4));
    give_column(out_, "voronoi_area", [&](std::size_t tile, const TileMesh& mesh, std::size_t v) {
      const bool first = tile == 2 && mesh.point_ghost[v] != 0 && mesh.point_ghost[v - 1] == 0;
      return first ? wrong : made_up_volume(mesh.ids[v]);
    });
  }
  const TemporaryFolder folder_;
  const fs::path out_ = folder_.path() / "out";
};

TEST_F(Contradictions, ATileWithOtherDensitiesThanTheOwnerIsNamed) {
  store(1234);
  const std::string said = failure(out_, Errc::corrupt);
  EXPECT_NE(said.find("has another density than in"), said.npos) << said;
  EXPECT_NE(said.find("compute the columns again"), said.npos) << said;
}

TEST_F(Contradictions, AVertexThatOneTileCallsUnboundedIsNamed) {
  store(std::numeric_limits<double>::infinity());
  const std::string said = failure(out_, Errc::corrupt);
  EXPECT_NE(said.find("has another density than in"), said.npos) << said;
}

TEST_F(Contradictions, ASizeThatIsNoneIsRefused) {
  for (const double wrong : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    fs::remove_all(out_);
    store(wrong);
    const std::string said = failure(out_, Errc::corrupt);
    EXPECT_NE(said.find("the Voronoi cell of vertex"), said.npos) << said;
  }
}

TEST_F(Contradictions, NegativeDensitiesAreRefused) {
  store_sample(out_, sample_tiles(sample_points(Shape::uniform, 2, 50), 2, 2));
  give_column(out_, "voronoi_area", [](std::size_t, const TileMesh&, std::size_t) { return 1.0; });
  give_column(out_, "density_mass", [](std::size_t, const TileMesh&, std::size_t v) { return v == 3 ? -1.0 : 1.0; });
  VoidsOptions options = options_of(1);
  options.by = "density_mass";
  const auto found = find_voids(out_, options, {});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::bad_input);
  EXPECT_NE(found.error().where.find("a density must not be negative"), std::string::npos) << found.error().where;
}

TEST_F(Contradictions, AStopLeavesTheResultAsItWas) {
  store(1);
  std::stop_source stop;
  stop.request_stop();
  failure(out_, Errc::interrupted, options_of(2), stop.get_token());
}

TEST_F(Contradictions, AllVerticesMayBeOutside) {
  store_sample(out_, sample_tiles(sample_points(Shape::uniform, 2, 4), 2, 2));
  give_column(out_, "voronoi_area",
              [](std::size_t, const TileMesh&, std::size_t) { return std::numeric_limits<double>::infinity(); });
  const auto found = find_voids(out_, options_of(1), {});
  ASSERT_TRUE(found) << found.error().where;
  EXPECT_EQ(found.value().found.zones, 0u);
  EXPECT_EQ(found.value().found.outside, 4u);
}

}  // namespace
}  // namespace tessera::voids

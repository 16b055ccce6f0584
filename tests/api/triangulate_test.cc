#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <map>
#include <thread>
#include <tuple>

#include "src/input/generate/generate.h"
#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cells_of;
using testing::cloud;
using testing::expected_cells;
using testing::TemporaryHome;

TriangulationOptions options_of(int dimension, std::uint64_t max_points_per_tile = 0) {
  TriangulationOptions options;
  options.dimension(dimension);
  options.max_points_per_tile(max_points_per_tile);
  options.threads(2);
  options.memory_bytes(std::uint64_t{1} << 30);
  return options;
}

// kind, dimension, most points a tile
class TriangulateArray : public ::testing::TestWithParam<std::tuple<std::string, int, int>> {
 protected:
  const TemporaryHome home_;
};

TEST_P(TriangulateArray, EqualsCgal) {
  const auto& [kind, dimension, limit] = GetParam();
  const auto points = cloud(kind, dimension, 400);
  const auto t = triangulate(points, options_of(dimension, static_cast<std::uint64_t>(limit)));
  const auto expected = expected_cells(points, dimension);
  EXPECT_EQ(difference(expected, cells_of(t)), "");
  EXPECT_EQ(t.cells(), expected.size());
  EXPECT_EQ(t.dimension(), dimension);
  EXPECT_EQ(t.points_read(), points.size() / static_cast<std::size_t>(dimension));
  EXPECT_EQ(t.vertices() + t.duplicates(), t.points_read());
  EXPECT_EQ(t.tiles() > 1, limit > 0);
}

INSTANTIATE_TEST_SUITE_P(Clouds, TriangulateArray,
                         ::testing::Combine(::testing::Values("uniform", "lattice", "slab", "corners"),
                                            ::testing::Values(2, 3), ::testing::Values(0, 60)));

TEST(Triangulate, ATileHasTheArraysThatItsHeaderPromises) {
  const TemporaryHome home;
  const auto points = cloud("uniform", 3, 1000);
  const auto t = triangulate(points, options_of(3, 200));
  ASSERT_GT(t.tiles(), 3u);
  std::size_t own = 0;
  for (std::size_t index = 0; index < t.tiles(); ++index) {
    const Tile tile = t.tile(index);
    const std::size_t n = tile.ids().size(), m = tile.ghost().size();
    ASSERT_EQ(tile.points().size(), 3 * n);
    ASSERT_EQ(tile.foreign().size(), n);
    ASSERT_EQ(tile.cells().size(), 4 * m);
    ASSERT_EQ(tile.neighbors().size(), 4 * m);
    EXPECT_TRUE(tile.attributes().empty());
    for (std::size_t i = 0; i < n; ++i) {
      own += tile.foreign()[i] == 0;
      EXPECT_EQ(std::memcmp(&tile.points()[3 * i], &points[3 * tile.ids()[i]], 24), 0);
    }
    for (std::size_t i = 0; i < 4 * m; ++i) {
      ASSERT_LT(static_cast<std::size_t>(tile.cells()[i]), n);
      const auto neighbor = tile.neighbors()[i];
      ASSERT_GE(neighbor, -2);
      if (neighbor < 0) continue;
      const auto* back = &tile.neighbors()[4 * static_cast<std::size_t>(neighbor)];
      EXPECT_NE(std::find(back, back + 4, static_cast<std::int32_t>(i / 4)), back + 4);
    }
  }
  EXPECT_EQ(own, t.vertices());
  auto without = options_of(3);
  without.neighbors(false);
  EXPECT_TRUE(triangulate(points, without).tile(0).neighbors().empty());
}

TEST(Triangulate, ATileOutlivesItsTriangulation) {
  const TemporaryHome home;
  const auto points = cloud("uniform", 2, 50);
  const Tile tile = triangulate(points, options_of(2)).tile(0);
  EXPECT_EQ(tile.ids().size(), 50u);
  EXPECT_EQ(tile.points()[0], points[2 * tile.ids()[0]]);
}

TEST(Triangulate, EqualPointsAreOneVertexWithTheLowestId) {
  const TemporaryHome home;
  auto points = cloud("uniform", 3, 300);
  const auto once = points;
  points.insert(points.end(), once.begin(), once.end());
  const auto t = triangulate(points, options_of(3, 80));
  EXPECT_EQ(t.duplicates(), 300u);
  EXPECT_EQ(difference(expected_cells(once, 3), cells_of(t)), "");
}

TEST(Triangulate, FilesOfAnyFormatMakeOneCloudWithTheirAttributes) {
  const TemporaryHome home;
  const auto las = home.path() / "a.las", text = home.path() / "b.xyz";
  ASSERT_TRUE(generate({*shape_named("terrain"), 3000, 7, 3}, las));
  std::ofstream(text) << "1e6 1e6 0\n1e6 2e6 0\n";
  auto options = options_of(0, 700);
  options.attributes({"classification", "intensity"});
  const auto t = triangulate({las.string(), (home.path() / "*.xyz").string()}, options);
  EXPECT_EQ(t.dimension(), 3);
  EXPECT_EQ(t.points_read(), 3002u);
  ASSERT_GT(t.tiles(), 1u);
  std::map<std::string, std::string> types;
  for (std::size_t i = 0; i < t.tiles(); ++i) {
    const Tile tile = t.tile(i);
    for (const auto& field : tile.attributes()) {
      types[field.name] = field.type;
      EXPECT_EQ(field.values.size(), tile.ids().size() * (field.type == "uint8" ? 1 : 2));
    }
  }
  EXPECT_EQ(types, (std::map<std::string, std::string>{{"classification", "uint8"}, {"intensity", "uint16"}}));
}

TEST(Triangulate, TheDimensionOfFilesIsFoundFromThem) {
  const TemporaryHome home;
  const auto flat = home.path() / "flat.xyz";
  std::ofstream(flat) << "0 0\n1 0\n0 1\n2 3\n";
  EXPECT_EQ(triangulate({flat.string()}, options_of(0)).dimension(), 2);
}

TEST(Triangulate, AResultInAFolderStaysAndIsOpenedAgain) {
  const TemporaryHome home;
  auto options = options_of(3, 100);
  options.folder(home.path() / "out");
  const auto points = cloud("uniform", 3, 500);
  const auto expected = expected_cells(points, 3);
  EXPECT_EQ(triangulate(points, options).folder(), home.path() / "out");
  const auto t = Triangulation::open(home.path() / "out");
  EXPECT_EQ(cells_of(t), expected);
  EXPECT_EQ(t.vertices(), 500u);

  const auto other = cloud("uniform", 3, 300, 2);
  const auto refused = testing::failure_of([&] { triangulate(other, options); });
  EXPECT_EQ(refused.cause(), Cause::usage);
  EXPECT_EQ(refused.what(), (home.path() / "out").string() + ": holds a finished result; overwrite(true) replaces it");
  options.overwrite(true);
  EXPECT_EQ(cells_of(triangulate(other, options)), expected_cells(other, 3));
}

TEST(Triangulate, ATemporaryFolderGoesWithTheLastCopy) {
  const TemporaryHome home;
  {
    auto t = triangulate(cloud("uniform", 2, 50), options_of(2));
    EXPECT_EQ(t.folder().parent_path(), home.path());
    auto copy = std::make_unique<Triangulation>(t);
    t = triangulate(cloud("uniform", 2, 60), options_of(2));
    EXPECT_EQ(home.entries(), 2u);
    EXPECT_EQ(copy->tile(0).ids().size(), 50u);
    copy.reset();
    EXPECT_EQ(home.entries(), 1u);
  }
  EXPECT_EQ(home.entries(), 0u);
}

TEST(Triangulate, ProgressIsToldInTheCallingThreadAndOnceAtTheEnd) {
  const TemporaryHome home;
  auto options = options_of(3, 5000);
  const auto caller = std::this_thread::get_id();
  std::vector<JobProgress> told;
  options.progress([&](const JobProgress& now) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    told.push_back(now);
  });
  triangulate(cloud("uniform", 3, 30'000), options);
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.back().phase, "done");
  EXPECT_EQ(told.back().points_total, 30'000u);
  EXPECT_EQ(told.back().points_triangulated, 30'000u);
  EXPECT_EQ(told.back().tiles_stored, told.back().tiles_total);
  for (std::size_t i = 1; i < told.size(); ++i) EXPECT_GE(told[i].seconds, told[i - 1].seconds);
}

TEST(Triangulate, SeveralAtOnceAndOneAfterTheOtherDoNotDisturbEachOther) {
  const TemporaryHome home;
  const auto kinds = std::vector<std::string>{"uniform", "lattice", "slab", "uniform"};
  for (int round = 0; round < 2; ++round) {
    std::vector<std::string> differences(kinds.size(), "not done");
    {
      std::vector<std::jthread> threads;
      for (std::size_t i = 0; i < kinds.size(); ++i) {
        threads.emplace_back([&, i] {
          const int dimension = i == 3 ? 2 : 3;
          const auto points = cloud(kinds[i], dimension, 2000, i + 1);
          const auto t = triangulate(points, options_of(dimension, 300));
          differences[i] = difference(expected_cells(points, dimension), cells_of(t));
        });
      }
    }
    for (const auto& each : differences) EXPECT_EQ(each, "");
  }
}

TEST(Triangulate, TilesMayBeReadFromSeveralThreadsAtOnce) {
  const TemporaryHome home;
  const auto t = triangulate(cloud("uniform", 3, 3000), options_of(3, 150));
  ASSERT_GT(t.tiles(), 10u);
  std::vector<std::size_t> cells(4, 0);
  {
    std::vector<std::jthread> threads;
    for (auto& sum : cells) {
      threads.emplace_back([&] {
        for (std::size_t i = 0; i < t.tiles(); ++i) {
          const Tile tile = t.tile(i);
          for (const auto ghost : tile.ghost()) sum += ghost == 0;
        }
      });
    }
  }
  for (const auto sum : cells) EXPECT_EQ(sum, t.cells());
}

}  // namespace
}  // namespace tessera

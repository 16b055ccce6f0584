#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "src/base/option.h"
#include "tests/tiling/run_fixture.h"

namespace tessera {
namespace {

using Route = RunFixture;

class RouteEveryCloud : public RunFixture,
                        public testing::WithParamInterface<std::tuple<std::string, PartitionKind, int>> {};

TEST_P(RouteEveryCloud, LosesNothingAndKeepsTheLimitOrRefuses) {
  const auto& [name, kind, dimension] = GetParam();
  const auto cloud = make_cloud(name, dimension, 1000);
  const std::set<Point> distinct(cloud.begin(), cloud.end());
  for (const RouteOptions& options : {RouteOptions{.kind = kind, .tiles = 7},
                                      RouteOptions{.kind = kind, .max_points_per_tile = 60, .options_key = "key"}}) {
    const auto run = route_points(cloud, dimension, options);
    if (!run) {
      EXPECT_EQ(run.error().code, Errc::bad_input) << run.error().where;
      const std::set<std::string> flat{"none", "one", "two", "identical", "collinear", "diagonal", "coplanar"};
      EXPECT_TRUE(flat.contains(name)) << run.error().where;
      EXPECT_FALSE(std::filesystem::exists(run_folder() / "points"));
      EXPECT_FALSE(std::filesystem::exists(run_folder() / "plan.json"));
      continue;
    }
    expect_complete(run.value(), cloud);
    EXPECT_EQ(progress_.tiles_total, run.value().partition.tiles());
    const auto back = open_run(run_folder());
    ASSERT_TRUE(back) << back.error().where;
    expect_same(back.value(), run.value());

    std::size_t vertices = 0;
    std::size_t duplicates = 0;
    for (std::uint32_t t = 0; t < run.value().partition.tiles(); ++t) {
      const auto tile = load_tile(run.value(), TileId{t});
      ASSERT_TRUE(tile) << tile.error().where;
      vertices += tile.value().points.size();
      duplicates += tile.value().duplicates.size();
      // Only equal points may exceed the limit, or points that a hash has thrown together.
      if (options.tiles == 0 && kind != PartitionKind::random && tile.value().points.size() > 1) {
        EXPECT_LE(run.value().tile_points[t], 60u);
      }
    }
    EXPECT_EQ(vertices, distinct.size());
    EXPECT_EQ(vertices + duplicates, cloud.size());
  }
}

INSTANTIATE_TEST_SUITE_P(, RouteEveryCloud,
                         testing::Combine(testing::ValuesIn(cloud_names()),
                                          testing::Values(PartitionKind::kdtree, PartitionKind::grid,
                                                          PartitionKind::octree, PartitionKind::random),
                                          testing::Values(2, 3)),
                         [](const auto& info) {
                           return std::get<0>(info.param) + "_" + name_of(std::get<1>(info.param)) + "_" +
                                  std::to_string(std::get<2>(info.param)) + "d";
                         });

TEST_F(Route, RefusesCloudsWithoutVolumeInOneSentence) {
  struct Case {
    std::string cloud;
    int dimension;
    std::size_t n;
    std::string sentence;
  };
  const Case cases[] = {
      {"none", 3, 0, "there are no points"},
      {"one", 3, 1, "there is 1 point; a 3D triangulation needs at least 4"},
      {"uniform", 3, 3, "there are 3 points; a 3D triangulation needs at least 4"},
      {"uniform", 2, 2, "there are 2 points; a 2D triangulation needs at least 3"},
      {"identical", 3, 1000, "all 1000 points are identical"},
      {"identical", 2, 1000, "all 1000 points are identical"},
      {"collinear", 2, 1000, "all 1000 points lie on one line; a 2D triangulation needs points off it"},
      {"diagonal", 3, 1000, "all 1000 points lie on one line; a 3D triangulation needs points off it"},
      {"coplanar", 3, 1000, "all 1000 points lie in one plane; a 3D triangulation needs points off it (try dim=2)"},
  };
  for (const Case& c : cases) {
    const auto path = write_npy(make_cloud(c.cloud, c.dimension, c.n), c.dimension);
    auto cloud = Cloud::open({path}, in_dimension(c.dimension));
    if (!cloud) {  // a reader may refuse an empty file itself
      EXPECT_EQ(c.n, 0u);
      continue;
    }
    const auto run = route(cloud.value(), run_folder(), {.tiles = 4}, progress_, {});
    ASSERT_FALSE(run);
    EXPECT_EQ(run.error().code, Errc::bad_input);
    EXPECT_EQ(in_plain_words(run.error().where), path + ": " + c.sentence);
  }
}

TEST_F(Route, RefusesATiltedPlane) {
  std::vector<Point> points;
  for (int i = 0; i < 1000; ++i) {
    const double x = i % 37;
    const double y = i % 41;
    points.push_back({x, y, 3 * x - 5 * y + 7});
  }
  const auto run = route_points(points, 3, {.tiles = 2});
  ASSERT_FALSE(run);
  EXPECT_NE(run.error().where.find("lie in one plane"), std::string::npos);
}

TEST_F(Route, FindsTheOnePointOffThePlaneHoweverLateItComes) {
  auto points = make_cloud("coplanar", 3, 5000);
  points.push_back({50, 50, 7 + 0x1p-40});
  const auto run = route_points(points, 3, {.tiles = 3});
  ASSERT_TRUE(run) << run.error().where;
  expect_complete(run.value(), points);
}

TEST_F(Route, TellsThatAFilterLeftNothing) {
  CloudOptions options;
  options.crop = Box{{5, 5, 5}, {6, 6, 6}};
  const auto cloud = open_cloud(write_npy(make_cloud("uniform", 3, 100), 3), options);
  const auto run = route(cloud, run_folder(), {.tiles = 4}, progress_, {});
  ASSERT_FALSE(run);
  EXPECT_NE(run.error().where.find("no points are left of 100: 100 were filtered out"), std::string::npos);
}

TEST_F(Route, CountsWhatIsFilteredAndKeepsRanksInTheInput) {
  auto points = make_cloud("uniform", 3, 2000);
  points[3].x = points[1500].z = std::numeric_limits<double>::quiet_NaN();
  CloudOptions options;
  options.skip_invalid = true;
  options.crop = Box{{0, 0, 0}, {0.5, 1, 1}};
  const auto cloud = open_cloud(write_npy(points, 3), options);
  const auto run = route(cloud, run_folder(), {.max_points_per_tile = 100}, progress_, {});
  ASSERT_TRUE(run) << run.error().where;
  std::uint64_t kept = 0;
  for (std::uint32_t t = 0; t < run.value().partition.tiles(); ++t) {
    for (const LocalPoint& p : read_points(run.value(), t)) {
      EXPECT_EQ(p.at, points[p.id.value]);
      ++kept;
    }
  }
  const CloudCounts& counts = run.value().counts;
  EXPECT_EQ(counts.read, 2000u);
  EXPECT_EQ(counts.invalid, 2u);
  EXPECT_EQ(kept + counts.invalid + counts.filtered, counts.read);
  EXPECT_NEAR(static_cast<double>(kept), 1000, 150);
  // The tiles are for what is left, not for what the header promises: a margin of a half at most.
  EXPECT_LE(run.value().partition.tiles(), 2 * (kept / 100 + 1));
  EXPECT_TRUE(open_run(run_folder()));
}

TEST_F(Route, CarriesTheRowsOfItsPoints) {
  const auto points = make_cloud("lattice", 3, 3000);
  const auto path = folder_ / "in.csv";
  {
    std::ofstream out(path);
    out << "x,y,z,quality\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
      out << points[i].x << ',' << points[i].y << ',' << points[i].z << ',' << i << ".5\n";
    }
  }
  CloudOptions options;
  options.attributes = {"quality"};
  const auto cloud = open_cloud(path.string(), options);
  ASSERT_EQ(row_bytes(cloud.schema()), 8u);
  const auto run = route(cloud, run_folder(), {.kind = PartitionKind::grid, .max_points_per_tile = 40}, progress_, {});
  ASSERT_TRUE(run) << run.error().where;
  expect_complete(run.value(), points);
  EXPECT_EQ(run.value().schema, cloud.schema());
  ASSERT_TRUE(open_run(run_folder()));
  for (std::uint32_t t = 0; t < run.value().partition.tiles(); ++t) {
    auto tile = load_tile(run.value(), TileId{t}).value();
    const auto rows = load_rows(run.value(), TileId{t}, tile.ids);
    ASSERT_TRUE(rows) << rows.error().where;
    ASSERT_EQ(rows.value().size(), 8 * tile.ids.size());
    for (std::size_t i = 0; i < tile.ids.size(); ++i) {
      double quality = 0;
      std::memcpy(&quality, rows.value().data() + 8 * i, 8);
      ASSERT_EQ(quality, static_cast<double>(tile.ids[i].value) + 0.5);
    }
    if (tile.ids.empty()) continue;
    const auto last_twice = load_rows(run.value(), TileId{t}, {tile.ids.back(), tile.ids.back()});
    EXPECT_EQ(last_twice.value().size(), 16u);
    tile.ids.push_back({tile.ids.back().value + 100000});
    EXPECT_EQ(load_rows(run.value(), TileId{t}, tile.ids).error().code, Errc::corrupt);
  }
}

TEST_F(Route, RoutesSeveralFilesAsOneCloud) {
  const auto points = make_cloud("uniform", 3, 3000);
  const auto middle = points.begin() + 1234;
  const auto a = write_npy({points.begin(), middle}, 3, "a.npy");
  const auto b = write_npy({middle, points.end()}, 3, "b.npy");
  const auto cloud = Cloud::open({a, b}, {});
  ASSERT_TRUE(cloud);
  const auto run = route(cloud.value(), run_folder(), {.max_points_per_tile = 500}, progress_, {});
  ASSERT_TRUE(run) << run.error().where;
  expect_complete(run.value(), points);
  ASSERT_EQ(run.value().inputs.size(), 2u);
  EXPECT_EQ(run.value().inputs[1].path, b);
  EXPECT_EQ(run.value().inputs[1].bytes, 128 + 24u * (3000 - 1234));
  EXPECT_EQ(progress_.points_routed, 3000u);
  EXPECT_EQ(progress_.points_total, 3000u);
}

// Several formats, small files and one that is read while it is routed, points twice in a file and across files.
TEST_F(Route, WritesTheSameBytesWhateverTheThreads) {
  std::filesystem::create_directory(folder_ / "in");
  const auto points = make_cloud("uniform", 3, 100'000);
  write_npy(points, 3, "in/20.npy");
  for (std::size_t i = 0; i < 30; ++i) {
    const std::vector<Point> some(points.begin() + static_cast<std::ptrdiff_t>(i * 40),
                                  points.begin() + static_cast<std::ptrdiff_t>(i * 40 + 100));
    if (i % 2 == 0) {
      write_npy(some, 3, "in/" + std::to_string(10 + i) + "_small.npy");
    } else {
      std::ofstream out(folder_ / "in" / (std::to_string(10 + i) + ".xyz"));
      out.precision(17);
      for (const Point& p : some) out << p.x << ' ' << p.y << ' ' << p.z << " 7\n" << (i == 5 ? "nan 1 2 3\n" : "");
    }
  }
  std::map<std::string, std::string> expected;
  for (const std::uint32_t threads : {1u, 2u, 5u}) {
    CloudOptions options{.skip_invalid = true, .attributes = {"column_4"}, .threads = threads};
    const auto run = route(open_cloud((folder_ / "in").string(), options), run_folder(), {.max_points_per_tile = 9000},
                           progress_, {});
    ASSERT_TRUE(run) << run.error().where;
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(run_folder())) {
      std::ifstream in(entry.path(), std::ios::binary);
      if (entry.is_regular_file()) files[entry.path()] = {std::istreambuf_iterator<char>(in), {}};
    }
    EXPECT_EQ(files.size(), 4u);
    if (expected.empty()) expected = files;
    EXPECT_TRUE(files == expected) << threads << " threads";
  }
}

// Routes stretches in any order, some of them twice, as nodes do of which some are lost.
class ShuffledRouter : public SplitRouter {
 public:
  std::uint64_t split_points(std::uint64_t) const override { return 65'536; }
  Result<std::vector<std::uint32_t>> route(const Cloud& cloud, const std::vector<InputSplit>& splits,
                                           const Partition& partition, const std::filesystem::path& folder,
                                           Progress& progress, const std::stop_token& stop) override {
    stretches_ = splits.size();
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < splits.size(); ++i) order.insert(order.end(), 1 + i % 2, i);
    std::shuffle(order.begin(), order.end(), std::mt19937_64(7));
    std::vector<std::uint32_t> attempts(splits.size());
    std::uint32_t attempt = 0;
    for (const std::size_t i : order) {
      SplitWork work{folder, ++attempt, 1 << 20};
      if (attempts[i] == 0) work.routed = [&](std::uint64_t points) { progress.points_routed += points; };
      // As another process knows the cloud.
      const Cloud theirs = Cloud::of(cloud.files(), cloud.schema(), cloud.options());
      BOOST_OUTCOME_TRYV(route_split(splits[i].here ? cloud : theirs, splits[i], partition, work, stop));
      attempts[i] = attempt;
    }
    return attempts;
  }
  std::size_t stretches_ = 0;
};

TEST_F(Route, GivesTheSameTilesWhoeverRoutesWhichStretch) {
  std::filesystem::create_directory(folder_ / "in");
  auto points = make_cloud("lattice", 3, 400'000);
  const auto others = make_cloud("uniform", 3, 160'000);  // of long numbers, for a text of several parts
  std::copy(others.begin(), others.end(), points.begin() + 230'000);
  const auto some = [&](std::size_t begin, std::size_t end) {
    return std::vector<Point>(points.begin() + static_cast<std::ptrdiff_t>(begin),
                              points.begin() + static_cast<std::ptrdiff_t>(end));
  };
  write_npy(some(0, 230'000), 3, "in/a.npy");
  {
    std::ofstream out(folder_ / "in" / "b.xyz");
    out.precision(17);
    for (const Point& p : some(230'000, 390'000)) out << p.x << ' ' << p.y << ' ' << p.z << " 7\n";
    out << "nan 1 2 3\n";
  }
  for (int i = 0; i < 20; ++i)
    write_npy(some(390'000 + i * 500, 390'000 + i * 500 + 500), 3, "in/c" + std::to_string(10 + i) + ".npy");
  const CloudOptions options{.skip_invalid = true, .attributes = {"column_4"}, .threads = 2};
  const auto cloud = open_cloud((folder_ / "in").string(), options);
  for (const auto kind : {PartitionKind::kdtree, PartitionKind::random, PartitionKind::grid}) {
    const RouteOptions limits{.kind = kind, .max_points_per_tile = kind == PartitionKind::grid ? 5000u : 20'000u};
    const auto one = route(cloud, folder_ / "one", limits, progress_, {});
    ShuffledRouter router;
    Progress progress;
    const auto many = route(cloud, run_folder(), limits, progress, {}, &router);
    ASSERT_TRUE(one && many) << (many ? one : many).error().where;
    EXPECT_EQ(router.stretches_, 10u);
    EXPECT_EQ(progress.points_routed, 400'000u);
    const auto again = open_run(run_folder());
    ASSERT_TRUE(again) << again.error().where;
    expect_same(many.value(), again.value());
    EXPECT_EQ(one.value().partition.boxes(), many.value().partition.boxes());
    EXPECT_EQ(one.value().tile_bounds, many.value().tile_bounds);
    EXPECT_EQ(one.value().seeds, many.value().seeds);
    EXPECT_EQ(many.value().counts.invalid, 1u);
    for (std::uint32_t t = 0; t < one.value().partition.tiles(); ++t) {
      const auto expected = read_points(one.value(), t);
      ASSERT_EQ(expected, read_points(many.value(), t)) << t;
      std::vector<PointId> ids;
      for (const LocalPoint& p : expected) ids.push_back(p.id);
      ASSERT_EQ(load_rows(one.value(), TileId{t}, ids).value(), load_rows(many.value(), TileId{t}, ids).value());
    }
    EXPECT_FALSE(std::filesystem::exists(routed_splits_folder(run_folder())));
  }
}

TEST_F(Route, StopsWhenAskedAndLeavesNothing) {
  std::stop_source stop;
  stop.request_stop();
  const auto cloud = open_cloud(write_npy(make_cloud("uniform", 3, 1000), 3), 3);
  const auto run = route(cloud, run_folder(), {.tiles = 4}, progress_, stop.get_token());
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, Errc::interrupted);
  EXPECT_FALSE(std::filesystem::exists(run_folder() / "points"));
}

TEST_F(Route, StartsAfreshInAFolderThatWasHalfRouted) {
  const auto points = make_cloud("uniform", 3, 1000);
  std::filesystem::create_directories(run_folder() / "points");
  std::filesystem::create_directories(run_folder() / "attributes");
  write_text(run_folder() / "points" / "000001.bin", "left over");
  write_text(run_folder() / "attributes" / "000001.bin", "left over");
  write_text(run_folder() / "plan.json.tmp", "left over");
  EXPECT_EQ(open_run(run_folder()).error().code, Errc::io);
  const auto run = route_points(points, 3, {.tiles = 4});
  ASSERT_TRUE(run) << run.error().where;
  expect_complete(run.value(), points);
  EXPECT_FALSE(std::filesystem::exists(run_folder() / "attributes"));
  EXPECT_FALSE(std::filesystem::exists(run_folder() / "plan.json.tmp"));
}

TEST_F(Route, RefusesAbsurdNumbersOfTiles) {
  const auto run = route_points(make_cloud("uniform", 3, 100), 3, {.tiles = 4'000'000'000u});
  ASSERT_FALSE(run);
  EXPECT_EQ(run.error().code, Errc::usage);
}

}  // namespace
}  // namespace tessera

// What the result may not depend on.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "src/result/tile_source.h"
#include "tests/engine/engine_run.h"
#include "tests/engine/sets.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

struct Case {
  const char* kind;
  int dimension;
  PartitionKind partition;
};

class Invariance : public ::testing::TestWithParam<Case> {
 protected:
  // About 600 points, and every ninth a second time.
  std::vector<Point> points() const {
    std::vector<Point> list;
    for (const LocalPoint& p : make_cloud(GetParam().kind, GetParam().dimension, 600, 11)) list.push_back(p.at);
    const std::size_t n = list.size();
    for (std::size_t i = 0; i < n; i += 9) list.push_back(list[i]);
    return list;
  }

  EngineOptions options(std::uint32_t tiles) const {
    EngineOptions made;
    made.dimension = GetParam().dimension;
    made.partition = GetParam().partition;
    made.tiles = tiles;
    made.threads = 2;
    return made;
  }

  // Runs the engine into folder `name` of the scratch folder.
  fs::path run(const std::string& name, const std::vector<Point>& points, const EngineOptions& with) const {
    const fs::path out = scratch_.path() / name, input = scratch_.path() / "cloud.npy";
    std::vector<double> coordinates;
    for (const Point& p : points) {
      for (int i = 0; i < with.dimension; ++i) coordinates.push_back(p[i]);
    }
    const auto written = write_npy(input, with.dimension, coordinates);
    EXPECT_TRUE(written);
    const auto made = run_engine(input, out, with);
    EXPECT_TRUE(made) << made.error().where;
    return out;
  }

  static Digest digest(const fs::path& out) { return read_manifest(out).value().digest.value(); }

  static std::vector<IdCell> cells(const fs::path& out) {
    std::vector<TileMesh> meshes;
    const auto source = TileSource::open(out).value();
    for (std::size_t i = 0; i < source.tiles(); ++i) meshes.push_back(source.read(i, {}).value().mesh);
    return main_cells(meshes);
  }

  // All that is promised to be the same byte for byte: everything but the manifest, which has timings.
  static std::map<std::string, std::string> contents(const fs::path& out) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      if (!entry.is_regular_file() || entry.path().filename() == "manifest.json") continue;
      std::ifstream file(entry.path(), std::ios::binary);
      files[fs::relative(entry.path(), out).string()] = {std::istreambuf_iterator<char>(file), {}};
    }
    return files;
  }

  static void expect_equal_bytes(const fs::path& a, const fs::path& b) {
    const auto first = contents(a), second = contents(b);
    ASSERT_EQ(first.size(), second.size());
    EXPECT_GT(first.size(), 2u);
    for (const auto& [name, bytes] : first) {
      EXPECT_TRUE(second.contains(name) && second.at(name) == bytes) << name << " differs";
    }
  }

 private:
  TemporaryFolder scratch_ = TemporaryFolder::make().value();
};

TEST_P(Invariance, PermutedInputGivesTheSameCells) {
  const auto original = points();
  std::vector<std::uint64_t> order(original.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937_64(3));
  std::vector<Point> permuted;
  for (const auto i : order) permuted.push_back(original[i]);
  // The id of a vertex: the lowest of its coordinates, in the original order.
  std::map<Point, PointId> id_of;
  for (std::size_t i = 0; i < original.size(); ++i) id_of.emplace(original[i], PointId{i});

  const auto expected = cells(run("original", original, options(7)));
  auto got = cells(run("permuted", permuted, options(7)));
  for (IdCell& cell : got) {
    for (auto& id : cell) id = id == infinite_id ? id : id_of.at(permuted[id.value]);
    std::sort(cell.begin(), cell.end());
  }
  std::sort(got.begin(), got.end());
  EXPECT_FALSE(expected.empty());
  EXPECT_EQ(difference(expected, got), "");
  EXPECT_EQ(expected.size(), got.size());
}

TEST_P(Invariance, AnotherPartitionGivesTheSameDigestAndOnePointLessAnother) {
  auto cloud = points();
  const auto expected = digest(run("first", cloud, options(7)));
  for (const auto kind : {PartitionKind::kdtree, PartitionKind::grid, PartitionKind::octree, PartitionKind::random}) {
    auto other = options(9);
    other.partition = kind;
    other.threads = 1;
    EXPECT_EQ(digest(run(name_of(kind), cloud, other)), expected) << name_of(kind);
  }
  cloud.erase(cloud.begin() + 300);
  EXPECT_NE(digest(run("less", cloud, options(7))), expected);
}

TEST_P(Invariance, ScalingByPowersOfTwoGivesTheSameCells) {
  const auto original = points();
  const auto expected = cells(run("original", original, options(7)));
  for (const int exponent : {-30, 40}) {
    auto scaled = original;
    for (Point& p : scaled) {
      for (int i = 0; i < 3; ++i) p[i] = std::ldexp(p[i], exponent);
    }
    EXPECT_EQ(cells(run("scaled" + std::to_string(exponent), scaled, options(7))), expected) << "by 2^" << exponent;
  }
}

TEST_P(Invariance, AnyNumberOfTilesGivesTheSameCells) {
  const auto original = points();
  const auto one = run("1", original, options(1));
  const auto expected = cells(one);
  for (const std::uint32_t tiles : {2u, 3u, 5u, 7u, 16u, 33u, 64u}) {
    const auto out = run(std::to_string(tiles), original, options(tiles));
    EXPECT_EQ(cells(out), expected) << tiles << " tiles";
    EXPECT_EQ(digest(out), digest(one)) << tiles << " tiles";
  }
}

TEST_P(Invariance, OnePartitionGivesTheSameBytesWhateverTheThreadsKeepAndMemory) {
  const auto original = points();
  const auto expected = run("first", original, options(7));
  int count = 0;
  for (const std::uint32_t threads : {1u, 2u, 4u}) {
    for (const TileRetention keep : {TileRetention::whole, TileRetention::reduced, TileRetention::by_budget}) {
      for (const std::uint64_t memory : {std::uint64_t{1}, std::uint64_t{4} << 30}) {
        auto other = options(7);
        other.threads = threads;
        other.keep = keep;
        other.memory_bytes = memory;
        SCOPED_TRACE(text_of(other));
        expect_equal_bytes(expected, run("other" + std::to_string(++count), original, other));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Clouds, Invariance,
    ::testing::Values(Case{"uniform", 3, PartitionKind::kdtree}, Case{"lattice", 3, PartitionKind::octree},
                      Case{"slab", 3, PartitionKind::grid}, Case{"corners", 3, PartitionKind::random},
                      Case{"jitter", 3, PartitionKind::kdtree}, Case{"lattice", 2, PartitionKind::kdtree},
                      Case{"clusters", 2, PartitionKind::grid}, Case{"planes", 2, PartitionKind::random}),
    [](const auto& info) {
      return std::string(info.param.kind) + std::to_string(info.param.dimension) + name_of(info.param.partition);
    });

}  // namespace
}  // namespace tessera::testing

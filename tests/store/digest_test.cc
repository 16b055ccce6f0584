#include "src/result/store/digest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <functional>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include "tests/store/sample_result.h"

namespace tessera::test {
namespace {

class DigestOf : public testing::TestWithParam<int> {
 protected:
  int dimension() const { return GetParam(); }
  std::size_t corners() const { return static_cast<std::size_t>(dimension()) + 1; }
  std::vector<Point> points_ = sample_points(Shape::uniform, GetParam(), 300);
  TileMesh mesh_ = sample_tiles(points_, GetParam(), 1)[0];
};
INSTANTIATE_TEST_SUITE_P(Dimensions, DigestOf, testing::Values(2, 3));

Digest sum_of(const std::vector<TileMesh>& meshes) {
  Digest sum;
  for (const auto& mesh : meshes) sum += digest_of(mesh);
  return sum;
}

TEST_P(DigestOf, TilesAddUpToTheSameWhateverTheirNumber) {
  for (const std::uint32_t tiles : {2u, 5u, 60u}) {
    EXPECT_EQ(sum_of(sample_tiles(points_, dimension(), tiles)), digest_of(mesh_)) << tiles;
  }
}

TEST_P(DigestOf, NeitherTheOrderOfVerticesNorThatOfCellsOrCornersMatters) {
  std::mt19937 random(5);
  TileMesh other = mesh_;
  std::vector<std::size_t> place(mesh_.points.size()), order(mesh_.cell_ghost.size());
  std::iota(place.begin(), place.end(), 0);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(place.begin(), place.end(), random);
  std::shuffle(order.begin(), order.end(), random);
  for (std::size_t i = 0; i < place.size(); ++i) {
    other.points[place[i]] = mesh_.points[i];
    other.ids[place[i]] = mesh_.ids[i];
  }
  for (std::size_t c = 0; c < order.size(); ++c) {
    const auto to = static_cast<std::ptrdiff_t>(order[c] * corners());
    for (std::size_t k = 0; k < corners(); ++k)
      other.cells[order[c] * corners() + k] =
          static_cast<std::int32_t>(place[static_cast<std::size_t>(mesh_.cells[c * corners() + k])]);
    std::shuffle(other.cells.begin() + to, other.cells.begin() + to + static_cast<std::ptrdiff_t>(corners()), random);
  }
  ASSERT_NE(other.cells, mesh_.cells);
  EXPECT_EQ(digest_of(other), digest_of(mesh_));
}

TEST_P(DigestOf, EveryChangeOfATriangulationChangesIt) {
  using Change = std::function<void(TileMesh&)>;
  std::vector<Change> changes{
      [](TileMesh& m) { m.ids[7].value ^= 1; },
      [](TileMesh& m) { m.ids[7].value ^= std::uint64_t{1} << 63; },
      [](TileMesh& m) { std::swap(m.ids[7], m.ids[8]); },
      [](TileMesh& m) { m.cell_ghost[11] = 1; },
      [](TileMesh& m) { m.point_ghost[11] = 1; },
      [](TileMesh& m) { m.cells[5] = m.cells[5] == 0 ? 1 : 0; },
      [&](TileMesh& m) {
        std::copy_n(m.cells.begin(), corners(), m.cells.end() - static_cast<std::ptrdiff_t>(corners()));
      },
  };
  for (int axis = 0; axis < dimension(); ++axis) {
    changes.push_back([axis](TileMesh& m) { m.points[3][axis] = std::nextafter(m.points[3][axis], 2.0); });
    changes.push_back([axis](TileMesh& m) { m.points[3][axis] = -m.points[3][axis]; });
    changes.push_back([axis](TileMesh& m) { std::swap(m.points[3][axis], m.points[4][axis]); });
  }
  std::set<std::string> texts{digest_text(digest_of(mesh_))};
  for (const auto& change : changes) {
    TileMesh other = mesh_;
    change(other);
    texts.insert(digest_text(digest_of(other)));
  }
  EXPECT_EQ(texts.size(), changes.size() + 1);
}

// Every vertex and every edge is in as many cells of one as of the other.
TEST_P(DigestOf, CellsThatShareAllTheirEdgesWithOthersAreOthers) {
  const auto trade = [&](int parity) {
    TileMesh mesh = mesh_;
    mesh.cells.clear();
    for (std::int32_t choice = 0; choice < 8; ++choice) {
      if (std::popcount(static_cast<unsigned>(choice)) % 2 != parity) continue;
      for (std::int32_t k = 0; k < 3; ++k) mesh.cells.push_back(2 * k + (choice >> k & 1));
      if (dimension() == 3) mesh.cells.push_back(6);
    }
    mesh.cell_ghost.assign(4, 0);
    return digest_of(mesh);
  };
  EXPECT_NE(trade(0), trade(1));
}

TEST(Digest, TheSamePointsInThePlaneAndInSpaceDiffer) {
  TileMesh flat;
  flat.dimension = 2;
  flat.points = {{1, 2, 0}};
  flat.ids = {{5}};
  flat.owners = {{0}};
  flat.point_ghost = {0};
  TileMesh solid = flat;
  solid.dimension = 3;
  EXPECT_NE(digest_of(flat), digest_of(solid));
}

TEST(Digest, OfNothingIsZero) { EXPECT_EQ(digest_text(digest_of(TileMesh{})), std::string(32, '0')); }

// A manifest outlives the program that wrote it: the value is part of the format.
TEST(Digest, OfATriangleIsTheSameInEveryVersion) {
  TileMesh mesh;
  mesh.dimension = 2;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 0.5, 0}};
  mesh.ids = {{3}, {1}, {2}};
  mesh.owners = {{0}, {0}, {0}};
  mesh.point_ghost = {0, 0, 0};
  mesh.cells = {0, 1, 2};
  mesh.cell_ghost = {0};
  EXPECT_EQ(digest_text(digest_of(mesh)), "728d3106a6658d24bc9a355e900a8c68");
}

TEST(Digest, OneOfAnEarlierDefinitionIsPassedOver) {
  const test::TemporaryFolder folder;
  test::store_sample(folder.path(), sample_tiles(sample_points(Shape::uniform, 3, 60), 3, 2));
  const auto path = folder.path() / "manifest.json";
  std::ostringstream read;
  read << std::ifstream(path).rdbuf();
  std::string text = read.str();
  ASSERT_TRUE(read_manifest(folder.path()).value().digest);
  const std::string now = "\"digest2\"", before = "\"digest\"";
  for (auto at = text.find(now); at != std::string::npos; at = text.find(now)) text.replace(at, now.size(), before);
  std::ofstream(path, std::ios::trunc) << text;
  const auto old = read_manifest(folder.path());
  ASSERT_TRUE(old) << old.error().where;
  EXPECT_FALSE(old.value().digest);
  for (const auto& entry : old.value().tiles) EXPECT_FALSE(entry.digest) << entry.tile.value;
}

TEST(Digest, AddsWithCarry) {
  Digest sum{~std::uint64_t{0}, 1};
  EXPECT_EQ(sum += (Digest{2, 3}), (Digest{1, 5}));
  EXPECT_EQ(sum += (Digest{~std::uint64_t{0}, ~std::uint64_t{0}}), (Digest{0, 5}));
}

TEST(Digest, ReadsBackFromItsTextAndFromNoOther) {
  const Digest digest{0x0123456789abcdef, 0xf0e1d2c3b4a59687};
  EXPECT_EQ(digest_text(digest), "f0e1d2c3b4a596870123456789abcdef");
  EXPECT_EQ(parse_digest(digest_text(digest)), digest);
  for (const char* text :
       {"", "f0e1d2c3b4a596870123456789abcde", "f0e1d2c3b4a596870123456789abcdef0", "F0e1d2c3b4a596870123456789abcdef",
        "g0e1d2c3b4a596870123456789abcdef", "-0e1d2c3b4a596870123456789abcdef"})
    EXPECT_FALSE(parse_digest(text)) << text;
}

}  // namespace
}  // namespace tessera::test

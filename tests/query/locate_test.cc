#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/query/query_testing.h"

namespace tessera {
namespace {

using query::Cell;
using query::StoredTriangulation;
using test::QuerySample;
using test::SampleKind;
using test::Tiles;

class EveryResult : public testing::TestWithParam<SampleKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EveryResult, testing::ValuesIn(test::sample_kinds()),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });

std::vector<Cell> located(const StoredTriangulation& result, const std::vector<Point>& points, unsigned threads = 2) {
  auto cells = result.locate(points, {.threads = threads});
  EXPECT_TRUE(cells) << (cells ? "" : cells.error().where);
  return cells ? std::move(cells).value() : std::vector<Cell>(points.size());
}

TEST_P(EveryResult, TellsTheCellThatHasAPointAsCgalDoes) {
  const QuerySample sample(GetParam());
  const auto result = sample.open();
  const auto questions = sample.questions(400, 1);
  const auto cells = located(result, questions);
  std::size_t inside = 0;
  for (std::size_t i = 0; i < questions.size(); ++i) {
    const IdCell* right = sample.right_cell(questions[i]);
    ASSERT_EQ(static_cast<bool>(cells[i]), right != nullptr) << i;
    if (right == nullptr) continue;
    ++inside;
    EXPECT_EQ(test::ids_of(cells[i]), *right) << i;
  }
  EXPECT_GT(inside, questions.size() / 4);
  EXPECT_LT(inside, questions.size());
}

TEST_P(EveryResult, TellsThePlaceInTheMainTile) {
  const QuerySample sample(GetParam());
  const auto result = sample.open();
  for (const Cell& cell : located(result, sample.questions(100, 2))) {
    if (!cell) continue;
    const TileSource& source = result.source();
    const auto tile = source.read(source.find(cell.tile).value(), {});
    ASSERT_TRUE(tile);
    const TileMesh& mesh = tile.value().mesh;
    const auto at = static_cast<std::size_t>(cell.cell);
    ASSERT_LT(at, mesh.cell_ghost.size());
    EXPECT_EQ(mesh.cell_ghost[at], 0);
    const auto corners = static_cast<std::size_t>(sample.dimension()) + 1;
    for (std::size_t k = 0; k < corners; ++k)
      EXPECT_EQ(mesh.ids[static_cast<std::size_t>(mesh.cells[at * corners + k])], cell.vertices[k]);
  }
}

TEST_P(EveryResult, TellsTheNeighborsOfACell) {
  const QuerySample sample(GetParam());
  const auto result = sample.open();
  const std::size_t corners = static_cast<std::size_t>(sample.dimension()) + 1;
  for (const Cell& cell : located(result, sample.questions(60, 3))) {
    if (!cell) continue;
    const auto details = result.details(cell);
    ASSERT_TRUE(details) << details.error().where;
    ASSERT_EQ(details.value().neighbors.size(), corners);
    for (std::size_t k = 0; k < corners; ++k) {
      IdCell facet = cell.vertices;
      facet[k] = query::no_id;
      std::sort(facet.begin(), facet.end());
      std::vector<IdCell> both;
      for (const auto& other : sample.cells())
        if (std::includes(other.begin(), other.end(), facet.begin(), facet.begin() + static_cast<int>(corners) - 1))
          both.push_back(other);
      std::erase(both, test::ids_of(cell));
      const Cell& neighbor = details.value().neighbors[k];
      ASSERT_EQ(static_cast<bool>(neighbor), both.size() == 1);
      if (neighbor) {
        EXPECT_EQ(test::ids_of(neighbor), both[0]);
      }
    }
  }
}

TEST(Locate, GivesTheSameAnswersWithHardlyAnyMemoryAndAnyThreads) {
  for (const auto tiles : {Tiles::slabs, Tiles::random}) {
    const QuerySample sample({.cloud = "uniform", .dimension = 3, .tiles = tiles, .number = 6}, 600);
    const auto questions = sample.questions(2000, 4);
    const auto plenty = sample.open();
    const auto answers = located(plenty, questions, 1);
    EXPECT_LE(plenty.tiles_read(), 6u);
    const auto little = sample.open(1);
    EXPECT_EQ(located(little, questions, 3), answers);
    EXPECT_GT(little.tiles_read(), 6u);
  }
}

TEST(Locate, NamesTheDamagedTile) {
  const QuerySample sample({.cloud = "uniform", .dimension = 3, .number = 3}, 600);
  const auto path = sample.out() / "tiles" / "000001.vtu";
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 100);
  const auto result = sample.open();
  const auto cells = result.locate(sample.questions(500, 5), {.threads = 2});
  ASSERT_FALSE(cells);
  EXPECT_EQ(cells.error().code, Errc::corrupt);
  EXPECT_NE(cells.error().where.find("000001.vtu"), std::string::npos) << cells.error().where;
}

TEST(Locate, SaysSoWhenStopped) {
  const QuerySample sample({.cloud = "uniform", .dimension = 2, .number = 2});
  std::stop_source stop;
  stop.request_stop();
  const auto cells = sample.open().locate(sample.questions(10, 6), {.threads = 1, .stop = stop.get_token()});
  ASSERT_FALSE(cells);
  EXPECT_EQ(cells.error().code, Errc::interrupted);
}

}  // namespace
}  // namespace tessera

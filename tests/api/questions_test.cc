// Questions; that the answers are right is tested in tests/query.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <stop_token>
#include <vector>

#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cells_of;
using testing::cloud;
using testing::failure_of;
using testing::TemporaryHome;

Triangulation sample(const std::vector<double>& points, int dimension) {
  return triangulate(points, TriangulationOptions().dimension(dimension).max_points_per_tile(100));
}

IdCell cell_of(std::span<const std::int64_t> vertices) {
  IdCell cell{infinite_id, infinite_id, infinite_id, infinite_id};
  for (std::size_t k = 0; k < vertices.size(); ++k) cell[k] = {static_cast<std::uint64_t>(vertices[k])};
  std::sort(cell.begin(), cell.end());
  return cell;
}

class QuestionsIn : public ::testing::TestWithParam<int> {
 protected:
  const TemporaryHome home_;
  const int dimension_ = GetParam();
  const std::size_t corners_ = static_cast<std::size_t>(dimension_) + 1;
  const std::vector<double> points_ = cloud("uniform", dimension_, 600);
  const Triangulation result_ = sample(points_, dimension_);
  const Questions questions_{result_};
};

TEST_P(QuestionsIn, VerticesAreInTheFirstOfTheirCellsAndFarPointsInNone) {
  const auto all = cells_of(result_);
  const auto located = questions_.locate(points_);
  ASSERT_EQ(located.tiles.size(), points_.size() / (corners_ - 1));
  for (std::size_t i = 0; i < located.tiles.size(); ++i) {
    const auto first = std::find_if(all.begin(), all.end(), [&](const IdCell& cell) {
      return std::find(cell.begin(), cell.end(), PointId{i}) != cell.end();
    });
    ASSERT_NE(first, all.end());
    const auto found = cell_of(std::span(located.vertices).subspan(i * corners_, corners_));
    EXPECT_EQ(found, *first);
    std::size_t index = 0;
    while (result_.tile(index).id() != static_cast<std::uint32_t>(located.tiles[i])) ++index;
    const Tile tile = result_.tile(index);
    std::vector<std::int64_t> there;
    for (std::size_t k = 0; k < corners_; ++k)
      there.push_back(static_cast<std::int64_t>(tile.ids()[static_cast<std::size_t>(
          tile.cells()[static_cast<std::size_t>(located.cells[i]) * corners_ + k])]));
    EXPECT_EQ(cell_of(there), found);
    if (i == 40) break;  // each reads tiles anew
  }
  const auto far = questions_.locate(std::vector<double>(corners_ - 1, 1e9));
  EXPECT_EQ(far.tiles, std::vector<std::int64_t>{-1});
  EXPECT_EQ(far.vertices, std::vector<std::int64_t>(corners_, -1));
}

TEST_P(QuestionsIn, AStarHasTheCellsOfItsVertex) {
  const auto all = cells_of(result_);
  for (std::uint64_t vertex = 0; vertex < 500; vertex += 97) {
    const auto star = questions_.star(vertex);
    std::vector<IdCell> found, wanted;
    for (std::size_t at = 0; at < star.cells.size(); at += corners_) {
      const std::vector<std::int64_t> one(star.cells.begin() + static_cast<std::ptrdiff_t>(at),
                                          star.cells.begin() + static_cast<std::ptrdiff_t>(at + corners_));
      found.push_back(cell_of(one));
    }
    std::copy_if(all.begin(), all.end(), std::back_inserter(wanted), [&](const IdCell& cell) {
      return std::find(cell.begin(), cell.end(), PointId{vertex}) != cell.end();
    });
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, wanted);
    EXPECT_EQ(star.cell_tiles.size(), wanted.size());
    EXPECT_EQ(questions_.star(vertex, star.tile).cells, star.cells);
    EXPECT_GT(star.voronoi_volume, 0);
    EXPECT_EQ(questions_.neighbours(vertex), star.neighbors);
    EXPECT_EQ(questions_.neighbours(vertex, star.tile), star.neighbors);
  }
}

TEST_P(QuestionsIn, ABoxAroundAllHasAllCells) {
  std::vector<double> box(2 * (corners_ - 1), 1e9);
  std::fill(box.begin(), box.begin() + dimension_, -1e9);
  const Tile all = questions_.cells_of_box(box);
  std::vector<IdCell> found;
  for (std::size_t c = 0; c < all.ghost().size(); ++c) {
    std::vector<std::int64_t> ids;
    for (std::size_t k = 0; k < corners_; ++k)
      ids.push_back(static_cast<std::int64_t>(all.ids()[static_cast<std::size_t>(all.cells()[c * corners_ + k])]));
    found.push_back(cell_of(ids));
  }
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, cells_of(result_));
  EXPECT_EQ(failure_of([&] { questions_.cells_of_box(box, 7); }).cause(), Cause::memory);
  const std::string everywhere = R"({"type":"Polygon","coordinates":[[[-1e9,-1e9],[1e9,-1e9],[1e9,1e9],[-1e9,1e9]]]})";
  EXPECT_EQ(questions_.cells_of_polygons(everywhere).ghost().size(), found.size());
}

TEST_P(QuestionsIn, WhatMakesNoSenseIsRefused) {
  const std::vector<double> nan(corners_ - 1, std::nan(""));
  EXPECT_EQ(failure_of([&] { questions_.locate(nan); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([&] { questions_.locate(std::vector<double>(corners_)); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([&] { questions_.star(1'000'000); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([&] { questions_.neighbours(1'000'000); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([&] { questions_.cells_of_box(nan); }).cause(), Cause::usage);
  EXPECT_EQ(failure_of([&] { questions_.cells_of_polygons("{}"); }).cause(), Cause::bad_input);
  EXPECT_EQ(failure_of([&] { questions_.interpolate(points_, "colour"); }).cause(), Cause::usage);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(failure_of([&] { questions_.locate(points_, stop.get_token()); }).cause(), Cause::interrupted);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, QuestionsIn, ::testing::Values(2, 3));

TEST(Interpolate, GivesHeightsBackAndTellsOfWhatTheyAreMade) {
  const TemporaryHome home;
  const auto file = home.path() / "plane.xyz";
  std::ofstream text(file);
  const auto points = cloud("uniform", 2, 300);
  for (std::size_t i = 0; i < points.size(); i += 2)
    text << points[i] << ' ' << points[i + 1] << ' ' << 2 * points[i] - points[i + 1] << '\n';
  text.close();
  const auto result = triangulate({file.string()}, TriangulationOptions().dimension(2));
  const Questions questions(result, 1 << 20, 2);
  const auto middle = questions.star(0).point;
  const std::vector<double> asked{middle[0] + 1e-3, middle[1], 1e9, 1e9};
  for (const auto method : {Method::linear, Method::natural}) {
    const auto found = questions.interpolate(asked, "z", method, true);
    ASSERT_EQ(found.values.size(), 2u);
    EXPECT_TRUE(std::isnan(found.values[1]));
    ASSERT_EQ(found.offsets.size(), 3u);
    EXPECT_EQ(found.offsets[1], found.vertices.size());
    double sum = 0;
    for (const double weight : found.weights) sum += weight;
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_NEAR(found.values[0], 2 * asked[0] - asked[1], 1e-3);
    EXPECT_TRUE(questions.interpolate(asked, "z", method).offsets.empty());
  }
}

// Rows in memory with heights and a mass: a slope, on which lines are where they have to be.
struct Row {
  double x, y, z;
  float mass;
  std::int32_t free;
};

Triangulation slope() {
  std::vector<Row> rows;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j)
      rows.push_back({i + 0.01 * j, static_cast<double>(j), i + 0.01 * j, static_cast<float>(i), 0});
  const Records records{std::as_bytes(std::span(rows)), rows.size(),
                        "[('x', '<f8'), ('y', '<f8'), ('z', '<f8'), ('mass', '<f4'), ('', '|V4')]"};
  return triangulate(records, TriangulationOptions().dimension(2).max_points_per_tile(60).attributes({"mass"}));
}

TEST(Lines, OfRowsWithHeightsAreArraysAndFiles) {
  const TemporaryHome home;
  const Triangulation t = slope();
  ASSERT_EQ(t.tile(0).attributes().size(), 2u);
  const LineSet lines = draw_contours(t, ContourRequest(5).base(2.5).index_every(2));
  EXPECT_EQ(lines.index, (std::vector<std::uint8_t>{1, 0, 1, 0}));
  const LineSet smooth = draw_contours(t, ContourRequest(5).base(2.5).smooth(1.5));
  EXPECT_EQ(smooth.values, lines.values);
  EXPECT_EQ(draw_contours(t, ContourRequest(5).base(2.5).min_length(50)).values.size(), 0u);
  EXPECT_EQ(lines.values, (std::vector<double>{2.5, 7.5, 12.5, 17.5}));
  ASSERT_EQ(lines.offsets.size(), 5u);
  EXPECT_EQ(lines.offsets.back() * 2, lines.points.size());
  for (std::size_t line = 0; line < 4; ++line)
    for (std::size_t i = lines.offsets[line]; i < lines.offsets[line + 1]; ++i)
      EXPECT_NEAR(lines.points[2 * i], lines.values[line], 1e-9);
  const std::vector<double> across{1, 10, 15, 10};
  const ProfileTable table = draw_profile(t, across);
  ASSERT_GT(table.values.size(), 14u);
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    EXPECT_NEAR(table.values[i], table.points[2 * i], 1e-9);
    EXPECT_NEAR(table.distances[i], table.points[2 * i] - 1, 1e-9);
    EXPECT_EQ(table.parts[i], 0u);
  }
  const auto csv = home.path() / "profile.csv";
  write_profile(t, across, csv);
  EXPECT_GT(std::filesystem::file_size(csv), 100u);
  EXPECT_EQ(failure_of([&] { write_profile(t, across, csv); }).what(),
            csv.string() + ": exists already; overwrite(true) replaces it");
  EXPECT_NE(write_contours(t, home.path() / "lines.geojson", ContourRequest(5)), "");
  EXPECT_NE(write_raster(t, home.path() / "shade.tif", RasterRequest(1).hillshade(90, 30)), "");
  const Raster lit = draw_raster(t, RasterRequest(1).hillshade(270, 45));
  EXPECT_GT(lit.pixels, 300u);
  // A slope of one in one that faces the light; less beside pixels without a height.
  EXPECT_GT(std::count(lit.values.begin(), lit.values.end(), 255.0), 250);
  for (const double pixel : lit.values) EXPECT_TRUE(std::isnan(pixel) || (pixel > 200 && pixel <= 255)) << pixel;
}

}  // namespace
}  // namespace tessera

// What viewers show of 3D results: the cells on the hull, those that a plane cuts, and one by its name.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "src/result/export/cell_filter.h"
#include "tests/query/query_testing.h"

namespace tessera {
namespace {

using query::CellSet;
using test::QuerySample;

class SolidCellsOf : public testing::TestWithParam<test::SampleKind> {};
std::vector<test::SampleKind> solid_kinds() {
  auto kinds = test::sample_kinds();
  std::erase_if(kinds, [](const auto& kind) { return kind.dimension == 2; });
  return kinds;
}
INSTANTIATE_TEST_SUITE_P(Kinds, SolidCellsOf, testing::ValuesIn(solid_kinds()),
                         [](const auto& kind) { return testing::PrintToString(kind.param); });

using Facet = std::array<PointId, 3>;

Facet facet_of(const IdCell& cell, std::size_t k) {
  Facet facet;
  std::size_t n = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (i != k) facet[n++] = cell[i];
  std::sort(facet.begin(), facet.end());
  return facet;
}

// In the set's order of corners.
std::vector<IdCell> cells_in(const CellSet& set) {
  std::vector<IdCell> cells;
  for (std::size_t i = 0; i < set.tiles.size(); ++i) {
    IdCell& cell = cells.emplace_back();
    for (std::size_t k = 0; k < 4; ++k)
      cell[k] = set.mesh.mesh.ids[static_cast<std::size_t>(set.mesh.mesh.cells[4 * i + k])];
  }
  return cells;
}

IdCell sorted(IdCell cell) {
  std::sort(cell.begin(), cell.end());
  return cell;
}

TEST_P(SolidCellsOf, TheHullAreTheFacetsThatOneCellHas) {
  const QuerySample sample(GetParam());
  std::map<Facet, int> times;
  for (const auto& cell : sample.cells())
    for (std::size_t k = 0; k < 4; ++k) ++times[facet_of(cell, k)];
  std::erase_if(times, [](const auto& facet) { return facet.second > 1; });
  const auto result = sample.open();
  const auto hull = result.hull({}, {});
  ASSERT_TRUE(hull) << hull.error().where;
  const std::vector<IdCell> cells = cells_in(hull.value().set);
  std::map<Facet, int> found;
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k)
      if ((hull.value().facets[i] >> k & 1u) != 0) ++found[facet_of(cells[i], k)];
  EXPECT_EQ(found, times);
  const auto too_many = result.hull({.cells_max = cells.size() - 1}, {});
  ASSERT_FALSE(too_many);
  EXPECT_EQ(too_many.error().code, Errc::memory);
  EXPECT_NE(too_many.error().where.find("the hull has more than"), std::string::npos);
  EXPECT_TRUE(result.hull({.cells_max = cells.size()}, {}));
}

TEST_P(SolidCellsOf, WithoutLongEdgesItIsTheBorderOfTheOthers) {
  const QuerySample sample(GetParam());
  const auto longest = [&](const auto& cell) {
    std::array<Point, 4> at;
    for (std::size_t k = 0; k < 4; ++k) at[k] = sample.points()[cell[k].value];
    return exports::longest_edge(at, false);
  };
  std::vector<double> all;
  for (const auto& cell : sample.cells()) all.push_back(longest(cell));
  std::sort(all.begin(), all.end());
  const auto result = sample.open();
  for (const double part : {0.05, 0.5, 0.9}) {
    const double most = all[static_cast<std::size_t>(static_cast<double>(all.size()) * part)];
    std::map<Facet, int> times;
    for (const auto& cell : sample.cells())
      if (longest(cell) <= most)
        for (std::size_t k = 0; k < 4; ++k) ++times[facet_of(cell, k)];
    std::erase_if(times, [](const auto& facet) { return facet.second > 1; });
    const auto border = result.hull({}, {}, most);
    ASSERT_TRUE(border) << border.error().where;
    const std::vector<IdCell> cells = cells_in(border.value().set);
    std::map<Facet, int> found;
    for (std::size_t i = 0; i < cells.size(); ++i)
      for (std::size_t k = 0; k < 4; ++k)
        if ((border.value().facets[i] >> k & 1u) != 0) ++found[facet_of(cells[i], k)];
    EXPECT_EQ(found, times) << part;
    // The same cells are left out of a box.
    query::Area area{.box = result.manifest().bounds};
    area.max_edge = most;
    const auto inside = result.cells(area, {}, {});
    ASSERT_TRUE(inside) << inside.error().where;
    EXPECT_EQ(inside.value().tiles.size(),
              static_cast<std::size_t>(std::upper_bound(all.begin(), all.end(), most) - all.begin()));
    // However they are asked for, the lengths are those of all.
    const auto& lengths = border.value().lengths;
    ASSERT_EQ(lengths.size(), 101u);
    EXPECT_TRUE(std::is_sorted(lengths.begin(), lengths.end()));
    EXPECT_GE(lengths[100], all.back());
    EXPECT_LT(lengths[100], all.back() * 1.03);
    const double middle = all[(all.size() - 1) / 2];
    EXPECT_GE(lengths[50], middle);
    EXPECT_LT(lengths[50], all[all.size() / 2] * 1.03);
  }
}

TEST_P(SolidCellsOf, ASectionHasEveryCellWithVerticesOnBothSides) {
  const QuerySample sample(GetParam(), 80);
  const auto result = sample.open();
  const Bounds& all = result.manifest().bounds;
  const double size = std::max({all.hi.x - all.lo.x, all.hi.y - all.lo.y, all.hi.z - all.lo.z});
  std::size_t cut = 0;
  for (const Point& normal : {Point{1, 0, 0}, Point{0, 0, 1}, Point{0.6, 0, -0.8}, Point{0.48, 0.64, 0.6}}) {
    for (const double part : {0.0, 0.1, 0.5, 0.93}) {
      query::Area area{.box = all};
      area.plane = query::Plane{{std::lerp(all.lo.x, all.hi.x, part), std::lerp(all.lo.y, all.hi.y, part),
                                 std::lerp(all.lo.z, all.hi.z, part)},
                                normal};
      const auto found = result.cells(area, {}, {});
      ASSERT_TRUE(found) << found.error().where;
      std::set<IdCell> cells;
      for (const IdCell& cell : cells_in(found.value())) EXPECT_TRUE(cells.insert(sorted(cell)).second);
      std::size_t on_both_sides = 0;
      for (const auto& cell : sample.cells()) {
        double least = size * 10, most = -least;
        for (const PointId id : cell) {
          const double above = area.plane->above(sample.points()[id.value]);
          least = std::min(least, above);
          most = std::max(most, above);
        }
        if (least < 0 && most > 0) {
          ++on_both_sides;
          EXPECT_TRUE(cells.contains(sorted(cell)));
        } else if (least > size * 1e-9 || most < -size * 1e-9) {
          EXPECT_FALSE(cells.contains(sorted(cell)));
        }
      }
      cut += on_both_sides;
      if (cells.size() < 2) continue;
      const auto too_many = result.cells(area, {.cells_max = cells.size() - 1}, {});
      ASSERT_FALSE(too_many);
      EXPECT_NE(too_many.error().where.find("the section has more than"), std::string::npos);
    }
  }
  EXPECT_GT(cut, 100u);
  // Beside the hull there is nothing.
  query::Area beside{.box = all};
  beside.plane = query::Plane{{all.hi.x + size, 0, 0}, {1, 0, 0}};
  EXPECT_TRUE(result.cells(beside, {}, {}).value().tiles.empty());
}

TEST_P(SolidCellsOf, ACellIsFoundByItsTileAndPlace) {
  const QuerySample sample(GetParam(), 60);
  const auto result = sample.open();
  const auto all = result.cells({.box = result.manifest().bounds}, {}, {});
  ASSERT_TRUE(all);
  const std::vector<IdCell> cells = cells_in(all.value());
  ASSERT_EQ(cells.size(), sample.cells().size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto found = result.cell(all.value().tiles[i], all.value().places[i]);
    ASSERT_TRUE(found) << found.error().where;
    EXPECT_EQ(IdCell(found.value().vertices), cells[i]);
    const auto details = result.details(found.value());
    ASSERT_TRUE(details);
    EXPECT_EQ(details.value().cell, found.value());
  }
  for (const auto& [tile, place] : {std::pair{TileId{999'998}, 0}, std::pair{all.value().tiles[0], 1'000'000},
                                    std::pair{all.value().tiles[0], -1}}) {
    const auto none = result.cell(tile, place);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, Errc::usage);
  }
}

TEST(Section, OfA2DResultIsRefused) {
  const QuerySample sample({.cloud = "uniform", .dimension = 2, .number = 2}, 60);
  query::Area area{.box = {}};
  area.plane = query::Plane{{0, 0, 0}, {1, 0, 0}};
  const auto refused = sample.open().cells(area, {}, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::usage);
}

}  // namespace
}  // namespace tessera

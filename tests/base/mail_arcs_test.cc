#include "src/base/mail_arcs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace tessera {
namespace {

using std::chrono::milliseconds;

// Rows of a tree over tiles first .. first + count - 1, cut in halves.
std::int32_t cut(TileLayout& layout, std::int32_t first, std::int32_t count) {
  if (count == 1) return -1 - first;
  const auto row = static_cast<std::int32_t>(layout.cuts.size());
  layout.cuts.emplace_back();
  const std::int32_t below = cut(layout, first, count / 2);
  const std::int32_t above = cut(layout, first + count / 2, count - count / 2);
  layout.cuts[static_cast<std::size_t>(row)].below = below;
  layout.cuts[static_cast<std::size_t>(row)].above = above;
  return row;
}

TileLayout layout_of(std::int32_t tiles) {
  TileLayout layout;
  cut(layout, 0, tiles);
  return layout;
}

std::set<std::int32_t> tiles_below(const TileLayout& layout, std::int32_t region) {
  if (region < 0) return {-1 - region};
  auto tiles = tiles_below(layout, layout.cuts[static_cast<std::size_t>(region)].below);
  tiles.merge(tiles_below(layout, layout.cuts[static_cast<std::size_t>(region)].above));
  return tiles;
}

TEST(MapRegions, AreTheTilesThemselvesWhenThereAreFew) {
  for (const int tiles : {1, 2, 100, 128}) {
    const MapRegions regions = map_regions_of(layout_of(tiles), static_cast<std::size_t>(tiles), 128);
    ASSERT_EQ(regions.codes.size(), static_cast<std::size_t>(tiles));
    for (int tile = 0; tile < tiles; ++tile)
      EXPECT_EQ(regions.codes[regions.of_tile[static_cast<std::size_t>(tile)]], -1 - tile);
  }
}

TEST(MapRegions, OfManyTilesAreRowsOfTheLayoutOfAboutEqualSize) {
  for (const int tiles : {129, 1000, 5000}) {
    const TileLayout layout = layout_of(tiles);
    const MapRegions regions = map_regions_of(layout, static_cast<std::size_t>(tiles), 128);
    ASSERT_EQ(regions.codes.size(), 128U);
    std::map<std::uint16_t, std::set<std::int32_t>> in;
    for (int tile = 0; tile < tiles; ++tile) in[regions.of_tile[static_cast<std::size_t>(tile)]].insert(tile);
    ASSERT_EQ(in.size(), 128U);
    std::size_t least = 5000, most = 0;
    for (const auto& [region, members] : in) {
      EXPECT_EQ(members, tiles_below(layout, regions.codes[region]));
      least = std::min(least, members.size());
      most = std::max(most, members.size());
    }
    EXPECT_LE(most, 3 * least);
  }
}

TEST(MapRegions, OfTilesWithoutAPlaceAreRunsOfThem) {
  const MapRegions regions = map_regions_of({}, 1000, 128);
  EXPECT_EQ(regions.codes.size(), 128U);
  EXPECT_TRUE(std::is_sorted(regions.of_tile.begin(), regions.of_tile.end()));
  for (std::size_t region = 0; region < regions.codes.size(); ++region)
    EXPECT_EQ(regions.of_tile[static_cast<std::size_t>(-1 - regions.codes[region])], region);
  EXPECT_TRUE(map_regions_of({}, 0, 128).codes.empty());
}

TEST(RecentMail, IsToldForASecondAtLeastAndTwoAtMost) {
  const RecentMail::Time start(std::chrono::hours(1));
  const std::vector<MailArc> one{{-1, -2, 5}}, other{{-1, -2, 2}, {3, -1, 9}};
  RecentMail mail;
  EXPECT_TRUE(mail.heaviest(start).empty());
  mail.add(one, start);
  mail.add(one, start + milliseconds(900));
  EXPECT_EQ(mail.heaviest(start + milliseconds(1800)), (std::vector<MailArc>{{-1, -2, 10}}));
  EXPECT_TRUE(mail.heaviest(start + milliseconds(2000)).empty());
  mail.add(other, start + milliseconds(1500));
  EXPECT_EQ(mail.heaviest(start + milliseconds(1600)), (std::vector<MailArc>{{-1, -2, 12}, {3, -1, 9}}));
  EXPECT_EQ(mail.heaviest(start + milliseconds(2600)), (std::vector<MailArc>{{3, -1, 9}, {-1, -2, 2}}));
  mail.add(one, start + milliseconds(9000));
  EXPECT_EQ(mail.heaviest(start + milliseconds(9000)), one);
}

TEST(RecentMail, IsBoundedByItsHeaviestArcs) {
  const RecentMail::Time start(std::chrono::hours(1));
  std::vector<MailArc> arcs;
  for (std::int32_t i = 0; i < 1000; ++i) arcs.push_back({-1 - i, i, static_cast<std::uint64_t>(i * 37 % 1000)});
  RecentMail mail;
  mail.add(arcs, start);
  const auto told = mail.heaviest(start);
  ASSERT_EQ(told.size(), mail_arcs_max);
  for (std::size_t i = 0; i < told.size(); ++i) EXPECT_EQ(told[i].bytes, 999 - i);
}

}  // namespace
}  // namespace tessera

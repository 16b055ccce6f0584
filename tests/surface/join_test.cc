// Small graphs over many regions, which decide alone, in groups, and in groups of groups: together they give the
// smallest minimum cut, whoever decides with whom. CUT_SEEDS: how many graphs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "src/surface/cut/reduce.h"
#include "src/surface/region.h"
#include "tests/cut/whole_graph.h"

namespace tessera::surface {
namespace {

using cut::WholeGraph;

std::uint64_t seeds() {
  const char* const wanted = std::getenv("CUT_SEEDS");
  return wanted ? std::stoull(wanted) : 3000;
}

struct Drawn {
  WholeGraph whole;
  std::vector<std::uint32_t> tile_of;  // by cell
  std::uint32_t tiles = 1;
};

Drawn draw(std::mt19937_64& random, bool small) {
  Drawn drawn;
  const auto width = 3 + static_cast<std::uint32_t>(random() % 8),
             height = 3 + static_cast<std::uint32_t>(random() % 6);
  drawn.whole = small ? cut::random_graph(random, 4 + static_cast<std::uint32_t>(random() % 9))
                      : cut::grid_graph(random, width, height);
  drawn.tiles = 1 + static_cast<std::uint32_t>(random() % 8);
  const bool slabs = !small && random() % 2 == 0;
  for (std::uint32_t cell = 0; cell < drawn.whole.cells(); ++cell)
    drawn.tile_of.push_back(slabs ? cell % width * drawn.tiles / width
                                  : static_cast<std::uint32_t>(random() % drawn.tiles));
  return drawn;
}

// A region, and which cells of the whole those of its kernel are.
struct Part {
  ReducedRegion region;
  std::vector<std::uint32_t> left;
};

class Deciding {
 public:
  Deciding(const Drawn& drawn, std::mt19937_64& random) : drawn_(drawn), random_(random), source_(drawn.whole.cells()) {
    for (std::uint32_t tile = 0; tile < drawn.tiles; ++tile) {
      std::vector<std::uint32_t> cells;
      for (std::uint32_t cell = 0; cell < drawn.whole.cells(); ++cell)
        if (drawn.tile_of[cell] == tile) cells.push_back(cell);
      parts_.push_back(decide(region_of(tile, cells), cells));
      part_of_.push_back(tile);
    }
  }

  // Until one is left, which has no border.
  std::vector<bool> run() {
    while (parts_.size() > 1) join_some();
    EXPECT_TRUE(parts_.front().region.names.empty());
    if (!parts_.front().left.empty()) {  // it was not to decide
      std::vector<ReducedRegion> last;
      last.push_back(std::move(parts_.front().region));
      auto joined = join(last, [](TileId) { return 0; });
      EXPECT_TRUE(joined);
      if (joined) take(kernel_of(std::move(joined.value().region), true), parts_.front().left);
    }
    return source_;
  }
  std::uint64_t cells_joined() const { return cells_joined_; }

 private:
  CutRegion region_of(std::uint32_t tile, const std::vector<std::uint32_t>& cells) const {
    const auto number = [&](std::uint32_t cell) {
      return static_cast<std::uint32_t>(std::lower_bound(cells.begin(), cells.end(), cell) - cells.begin());
    };
    CutRegion region;
    for (const std::uint32_t cell : cells) {
      region.graph.excess.push_back(drawn_.whole.excess[cell]);
      for (std::uint32_t facet = 0; facet < 4; ++facet) {
        const auto& side = drawn_.whole.sides[cell][facet];
        region.graph.capacity.push_back(side.capacity);
        if (side.cell == WholeGraph::nobody) {
          region.graph.back.push_back(cut::no_arc);
        } else if (drawn_.tile_of[side.cell] == tile) {
          region.graph.back.push_back(4 * number(side.cell) + side.facet);
        } else {
          const auto border = static_cast<std::uint32_t>(region.graph.borders.size());
          const auto arc = static_cast<cut::Arc>(region.graph.back.size());
          region.graph.back.push_back(cut::border_bit | border);
          region.graph.borders.push_back({arc, drawn_.whole.sides[side.cell][side.facet].capacity});
          const std::uint32_t here = 4 * cell + facet, there = 4 * side.cell + side.facet;
          region.names.push_back({{PointId{std::min(here, there)}, PointId{std::max(here, there)}, PointId{0}},
                                  TileId{drawn_.tile_of[side.cell]}});
          region.borders.push_back(border);
        }
      }
    }
    region.at_border.assign(region.names.size(), cut::Decided::no);
    EXPECT_TRUE(region.graph.sound());
    return region;
  }

  Part decide(CutRegion region, const std::vector<std::uint32_t>& cells) {
    const bool at_once = random_() % 3 == 0;
    return take(at_once ? all_of(std::move(region)) : kernel_of(std::move(region), true), cells);
  }
  // `cells`: of the whole, by cell of the region.
  Part take(Result<ReducedRegion> made, const std::vector<std::uint32_t>& cells) {
    EXPECT_TRUE(made) << made.error().where;
    Part part{std::move(made).value(), {}};
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
      if (part.region.open.contains(i)) part.left.push_back(cells[i]);
      if (part.region.sources.contains(i)) source_[cells[i]] = true;
    }
    EXPECT_EQ(part.left.size(), part.region.kernel.graph.cells());
    EXPECT_TRUE(part.region.kernel.graph.sound());
    return part;
  }

  // Two or more of them become one.
  void join_some() {
    const auto count = 2 + random_() % (parts_.size() - 1);
    std::vector<std::size_t> chosen(parts_.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = i;
    std::shuffle(chosen.begin(), chosen.end(), random_);
    chosen.resize(count);
    std::vector<ReducedRegion> regions;
    std::vector<std::uint32_t> cells;
    for (const std::size_t i : chosen) {
      regions.push_back(std::move(parts_[i].region));
      cells.insert(cells.end(), parts_[i].left.begin(), parts_[i].left.end());
    }
    cells_joined_ += cells.size();
    const auto joined_to = [&](TileId tile) -> std::optional<std::uint32_t> {
      const auto at = std::find(chosen.begin(), chosen.end(), part_of_[tile.value]);
      if (at == chosen.end()) return std::nullopt;
      return static_cast<std::uint32_t>(at - chosen.begin());
    };
    auto joined = join(regions, joined_to);
    ASSERT_TRUE(joined) << joined.error().where;
    ASSERT_TRUE(joined.value().region.graph.sound());
    Part part = decide(std::move(joined.value().region), cells);
    // The parts that stay, and the new one at the end.
    std::vector<Part> parts;
    std::vector<std::size_t> moved(parts_.size());
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (std::find(chosen.begin(), chosen.end(), i) != chosen.end()) continue;
      moved[i] = parts.size();
      parts.push_back(std::move(parts_[i]));
    }
    for (const std::size_t i : chosen) moved[i] = parts.size();
    parts.push_back(std::move(part));
    parts_ = std::move(parts);
    for (std::size_t& of : part_of_) of = moved[of];
  }

  const Drawn& drawn_;
  std::mt19937_64& random_;
  std::vector<bool> source_;
  std::vector<Part> parts_;
  std::vector<std::size_t> part_of_;  // by tile
  std::uint64_t cells_joined_ = 0;
};

TEST(Join, GivesTheSmallestMinimumCutWhoeverDecidesWithWhom) {
  std::uint64_t joined = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= seeds(); ++seed) {
    std::mt19937_64 random(seed);
    const bool small = seed % 2 == 0;
    const Drawn drawn = draw(random, small);
    Deciding deciding(drawn, random);
    const auto found = deciding.run();
    ASSERT_FALSE(HasFatalFailure()) << "seed " << seed;
    ASSERT_EQ(found, small ? cut::smallest_by_trying(drawn.whole) : cut::smallest_by_augmenting(drawn.whole))
        << "seed " << seed;
    joined += deciding.cells_joined();
    all += drawn.whole.cells();
  }
  EXPECT_GT(joined, all / 4);
}

TEST(Join, RefusesRegionsThatDoNotNameTheSameBorders) {
  std::uint64_t refused = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::mt19937_64 random(seed);
    WholeGraph whole;
    whole.sides.resize(2);
    whole.excess = {3, -3};
    ASSERT_TRUE(whole.join(0, 1, 2, 2));
    std::vector<ReducedRegion> regions;
    for (std::uint32_t tile = 0; tile < 2; ++tile) {
      CutRegion region;
      region.graph.excess = {whole.excess[tile]};
      region.graph.capacity = {2, 0, 0, 0};
      region.graph.back = {cut::border_bit, cut::no_arc, cut::no_arc, cut::no_arc};
      region.graph.borders = {{0, 2}};
      region.names = {{{PointId{1}, PointId{2}, PointId{3}}, TileId{1 - tile}}};
      region.at_border = {cut::Decided::no};
      region.borders = {0};
      regions.push_back(all_of(std::move(region)));
    }
    BorderName& name = regions[random() % 2].names.front();
    const bool other_facet = random() % 2 == 0;
    if (other_facet) {
      name.facet[random() % 3].value += 7;
    } else {
      name.to = TileId{2};
    }
    const auto joined = join(regions, [](TileId tile) -> std::optional<std::uint32_t> {
      if (tile.value > 1) return std::nullopt;
      return tile.value;
    });
    refused += !joined && joined.error().code == Errc::corrupt;
  }
  EXPECT_EQ(refused, 200u);
}

}  // namespace
}  // namespace tessera::surface

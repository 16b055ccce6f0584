// The flow within one region.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "src/surface/cut/certificate.h"
#include "src/surface/cut/search_trees.h"
#include "tests/cut/whole_graph.h"

namespace tessera::cut {
namespace {

std::vector<bool> solved(const WholeGraph& whole) {
  CutGraph graph = whole.as_one();
  EXPECT_TRUE(graph.sound());
  SearchTrees(graph).run();
  const CellSet reached = reached_from_excess(graph);
  EXPECT_FALSE(any_deficit(graph, reached));
  return as_bools(reached, whole.cells());
}

TEST(SearchTrees, FindTheSmallestMinimumCutOfSmallGraphs) {
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    std::mt19937_64 random(seed);
    const WholeGraph whole = random_graph(random, 2 + static_cast<std::uint32_t>(random() % 11));
    ASSERT_EQ(solved(whole), smallest_by_trying(whole)) << "seed " << seed;
  }
}

TEST(SearchTrees, FindTheSmallestMinimumCutOfGridsAndLongWays) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    std::mt19937_64 random(seed);
    const auto width = 1 + static_cast<std::uint32_t>(random() % 40),
               height = 1 + static_cast<std::uint32_t>(random() % 40);
    const WholeGraph whole = grid_graph(random, width, height);
    ASSERT_EQ(solved(whole), smallest_by_augmenting(whole)) << "seed " << seed;
    const WholeGraph other = random_graph(random, 300);
    ASSERT_EQ(solved(other), smallest_by_augmenting(other)) << "seed " << seed;
  }
}

TEST(SearchTrees, TakeTheLargestCapacitiesAndTerminals) {
  WholeGraph whole;
  whole.excess = {infinite_terminal, 0, -infinite_terminal, -5};
  whole.sides.resize(4);
  ASSERT_TRUE(whole.join(0, 1, capacity_max, capacity_max));
  ASSERT_TRUE(whole.join(1, 2, capacity_max, capacity_max));
  ASSERT_TRUE(whole.join(0, 1, capacity_max, 0));
  ASSERT_TRUE(whole.join(1, 3, 5, 0));
  EXPECT_EQ(solved(whole), smallest_by_trying(whole));
}

// Each cut has a proof, and whatever is changed in one, in the flow or in the set leaves none.
TEST(Certificate, ProvesWhatIsRightAndNothingElse) {
  std::uint64_t changed = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    std::mt19937_64 random(seed);
    const bool small = seed % 10 != 0;
    const WholeGraph whole = small ? random_graph(random, 2 + static_cast<std::uint32_t>(random() % 11))
                                   : grid_graph(random, 1 + static_cast<std::uint32_t>(random() % 20), 20);
    const CutGraph before = whole.as_one();
    CutGraph after = before;
    const CellSet source = SearchTrees(after).run();
    ASSERT_EQ(why_no_proof(before, after, source), "") << "seed " << seed;
    CellSet other(whole.cells());
    const auto flipped = static_cast<std::uint32_t>(random() % whole.cells());
    for (std::uint32_t cell = 0; cell < whole.cells(); ++cell)
      if (source.contains(cell) != (cell == flipped)) other.insert(cell);
    EXPECT_NE(why_no_proof(before, after, other), "") << "seed " << seed;
    CutGraph bad = after;
    ++bad.excess[flipped];
    EXPECT_NE(why_no_proof(before, bad, source), "") << "seed " << seed;
    bad = after;
    const auto arc = static_cast<Arc>(random() % bad.capacity.size());
    ++bad.capacity[arc];
    EXPECT_NE(why_no_proof(before, bad, source), "") << "seed " << seed;
    // Flow that keeps to all capacities but goes on from where it should stay.
    bad = after;
    for (Arc a = 0; a < bad.capacity.size(); ++a) {
      if (!is_inner(bad.back[a]) || bad.capacity[a] == 0 || bad.excess[a >> 2u] > 0 || source.contains(a >> 2u))
        continue;
      bad.push(a, 1);
      const bool still = bad.excess[bad.back[a] >> 2u] <= 0 && !source.contains(bad.back[a] >> 2u);
      EXPECT_EQ(why_no_proof(before, bad, source).empty(), still) << "seed " << seed;
      changed += still ? 0 : 1;
      break;
    }
  }
  EXPECT_GT(changed, 20u);
}

TEST(CutGraph, TellsWhatDoesNotFit) {
  WholeGraph whole;
  whole.excess = {1, -1};
  whole.sides.resize(2);
  ASSERT_TRUE(whole.join(0, 1, 3, 4));
  const CutGraph good = whole.as_one();
  EXPECT_TRUE(good.sound());
  const auto with = [&](const auto& change) {
    CutGraph bad = good;
    change(bad);
    return bad.sound();
  };
  EXPECT_FALSE(with([](CutGraph& g) { g.back[0] = 5; }));
  EXPECT_FALSE(with([](CutGraph& g) { g.back[0] = 1; }));
  EXPECT_FALSE(with([](CutGraph& g) { g.back[0] = 1000; }));
  EXPECT_FALSE(with([](CutGraph& g) { g.capacity[1] = 1; }));
  EXPECT_FALSE(with([](CutGraph& g) { g.capacity.pop_back(); }));
  EXPECT_FALSE(with([](CutGraph& g) { g.back[1] = border_bit; }));
  EXPECT_FALSE(with([](CutGraph& g) { g.borders.push_back({1, 1}); }));
  EXPECT_TRUE(with([](CutGraph& g) {
    g.borders.push_back({1, 1});
    g.back[1] = border_bit;
  }));
}

}  // namespace
}  // namespace tessera::cut

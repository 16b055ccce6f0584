// Cuts over several regions, against all source sets and against flows in one piece. CUT_SEEDS: how many graphs.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "tests/cut/regions.h"
#include "tests/cut/whole_graph.h"

namespace tessera::cut {
namespace {

std::uint64_t seeds() {
  const char* const wanted = std::getenv("CUT_SEEDS");
  return wanted ? std::stoull(wanted) : 2000;
}

struct Drawn {
  WholeGraph whole;
  std::vector<std::uint32_t> region_of;
  std::uint32_t regions = 2;
};

Drawn draw_small(std::mt19937_64& random) {
  Drawn drawn;
  drawn.whole = random_graph(random, 4 + static_cast<std::uint32_t>(random() % 9));
  drawn.regions = 2 + static_cast<std::uint32_t>(random() % 4);
  for (std::uint32_t cell = 0; cell < drawn.whole.cells(); ++cell)
    drawn.region_of.push_back(static_cast<std::uint32_t>(random() % drawn.regions));
  return drawn;
}

Drawn draw_grid(std::mt19937_64& random) {
  Drawn drawn;
  const auto width = 3 + static_cast<std::uint32_t>(random() % 8),
             height = 3 + static_cast<std::uint32_t>(random() % 6);
  drawn.whole = grid_graph(random, width, height);
  drawn.regions = 2 + static_cast<std::uint32_t>(random() % 4);
  const bool slabs = random() % 2 == 0;
  for (std::uint32_t cell = 0; cell < drawn.whole.cells(); ++cell)
    drawn.region_of.push_back(slabs ? cell % width * drawn.regions / width
                                    : static_cast<std::uint32_t>(random() % drawn.regions));
  return drawn;
}

NetworkOptions draw_options(std::mt19937_64& random, Mutant mutant = Mutant::none) {
  return {
      .bound = std::uint32_t{2} << random() % 4, .crashes = static_cast<std::uint32_t>(random() % 3), .mutant = mutant};
}

TEST(Regions, FindTheSmallestMinimumCutOfSmallGraphsInAnyOrderAndWithLosses) {
  for (std::uint64_t seed = 1; seed <= seeds(); ++seed) {
    std::mt19937_64 random(seed);
    const Drawn drawn = draw_small(random);
    const Split parts = split(drawn.whole, drawn.region_of, drawn.regions);
    for (const CutGraph& graph : parts.graphs) ASSERT_TRUE(graph.sound());
    const auto found = run_regions(parts, drawn.whole.cells(), draw_options(random), random);
    ASSERT_TRUE(found) << "no end, seed " << seed;
    ASSERT_EQ(found->source, smallest_by_trying(drawn.whole)) << "seed " << seed;
  }
}

TEST(Regions, FindTheSmallestMinimumCutOfGrids) {
  for (std::uint64_t seed = 1; seed <= seeds() / 2; ++seed) {
    std::mt19937_64 random(seed);
    const Drawn drawn = draw_grid(random);
    const Split parts = split(drawn.whole, drawn.region_of, drawn.regions);
    const auto found = run_regions(parts, drawn.whole.cells(), draw_options(random), random);
    ASSERT_TRUE(found) << "no end, seed " << seed;
    ASSERT_EQ(found->source, smallest_by_augmenting(drawn.whole)) << "seed " << seed;
  }
}

TEST(Regions, DecideAloneOnlyWhatIsRightAndTheirKernelsGiveTheRest) {
  std::uint64_t all = 0, left = 0;
  for (std::uint64_t seed = 1; seed <= seeds(); ++seed) {
    std::mt19937_64 random(seed);
    const bool small = seed % 2 == 0;
    const Drawn drawn = small ? draw_small(random) : draw_grid(random);
    Split parts = split(drawn.whole, drawn.region_of, drawn.regions);
    std::vector<bool> source(drawn.whole.cells());
    reduce(parts, source);
    for (const CutGraph& graph : parts.graphs) {
      ASSERT_TRUE(graph.sound()) << "seed " << seed;
      left += graph.cells();
    }
    all += drawn.whole.cells();
    const auto found = run_regions(parts, drawn.whole.cells(), draw_options(random), random);
    ASSERT_TRUE(found) << "no end, seed " << seed;
    for (std::uint32_t cell = 0; cell < drawn.whole.cells(); ++cell)
      if (found->source[cell]) source[cell] = true;
    ASSERT_EQ(source, small ? smallest_by_trying(drawn.whole) : smallest_by_augmenting(drawn.whole)) << "seed " << seed;
  }
  EXPECT_LT(left, all * 3 / 4);
  EXPECT_GT(left, 0u);
}

// Each is found by some of these graphs.
class Mutants : public testing::TestWithParam<Mutant> {};
TEST_P(Mutants, Die) {
  std::uint64_t found_out = 0;
  for (std::uint64_t seed = 1; seed <= 3000 && found_out == 0; ++seed) {
    std::mt19937_64 random(seed);
    const Drawn drawn = seed % 2 == 0 ? draw_small(random) : draw_grid(random);
    NetworkOptions options = draw_options(random, GetParam());
    options.bound = 2;
    const auto found =
        run_regions(split(drawn.whole, drawn.region_of, drawn.regions), drawn.whole.cells(), options, random);
    found_out += !found || found->source != smallest_by_augmenting(drawn.whole);
  }
  EXPECT_GT(found_out, 0u);
}
INSTANTIATE_TEST_SUITE_P(All, Mutants,
                         testing::Values(Mutant::no_flood, Mutant::labels_are_the_answer, Mutant::last_heard,
                                         Mutant::old_mail, Mutant::fixed_bound));

// A way over many borders and back: labels rise to the end of it.
TEST(Regions, FindAWayOverManyBorders) {
  for (const std::uint32_t cells : {3u, 5u, 9u, 33u}) {
    WholeGraph whole;
    whole.sides.resize(cells);
    whole.excess.assign(cells, 0);
    whole.excess.front() = 7;
    whole.excess.back() = -4;
    std::vector<std::uint32_t> region_of;
    for (std::uint32_t cell = 0; cell < cells; ++cell) region_of.push_back(cell % 2);
    for (std::uint32_t cell = 0; cell + 1 < cells; ++cell) ASSERT_TRUE(whole.join(cell, cell + 1, 5, 0));
    for (std::uint64_t seed = 1; seed < 20; ++seed) {
      std::mt19937_64 random(seed);
      const auto found = run_regions(split(whole, region_of, 2), cells, {.bound = 2, .crashes = 1}, random);
      ASSERT_TRUE(found);
      EXPECT_EQ(found->source, smallest_by_augmenting(whole));
      if (cells == 33) {
        EXPECT_GT(found->floods, 1u) << "the bound is raised when a flood meets a deficit";
      }
    }
  }
}

// All that is infinite, empty or full.
TEST(Regions, TakeWhatIsExtreme) {
  for (const std::uint32_t capacity : {0u, 1u, capacity_max})
    for (const std::int64_t ends : {std::int64_t{0}, std::int64_t{3}, infinite_terminal}) {
      WholeGraph whole;
      whole.sides.resize(6);
      whole.excess = {ends, 0, 0, 0, 0, -ends};
      for (std::uint32_t cell = 0; cell + 1 < 6; ++cell) ASSERT_TRUE(whole.join(cell, cell + 1, capacity, capacity));
      std::mt19937_64 random(1);
      const auto found = run_regions(split(whole, {0, 1, 2, 0, 1, 2}, 3), 6, {.bound = 2, .crashes = 2}, random);
      ASSERT_TRUE(found);
      EXPECT_EQ(found->source, smallest_by_trying(whole));
    }
  WholeGraph only_source;
  only_source.sides.resize(4);
  only_source.excess = {infinite_terminal, 0, 0, 0};
  for (std::uint32_t cell = 0; cell < 3; ++cell) ASSERT_TRUE(only_source.join(cell, cell + 1, 4, 4));
  std::mt19937_64 random(1);
  const auto found = run_regions(split(only_source, {0, 1, 0, 1}, 2), 4, {}, random);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->source, std::vector<bool>(4, true));
}

}  // namespace
}  // namespace tessera::cut

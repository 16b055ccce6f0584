#include "actors/harness/harness.h"

#include <gtest/gtest.h>

#include <stop_token>
#include <string>
#include <vector>

namespace tessera {
namespace {

struct Case {
  const char* kind;
  int dimension;
  std::size_t points;
  std::uint32_t tiles;
  PartitionKind partition;
  std::uint64_t seeds;
  std::uint64_t first_seed = 1;
};

HarnessOptions options_of(const Case& c) {
  HarnessOptions options;
  options.kind = c.kind;
  options.dimension = c.dimension;
  options.points = c.points;
  options.tiles = c.tiles;
  options.partition = c.partition;
  options.first_seed = c.first_seed;
  options.last_seed = c.first_seed + c.seeds - 1;
  return options;
}

std::string name_of_case(const ::testing::TestParamInfo<Case>& info) {
  return std::string(info.param.kind) + std::to_string(info.param.dimension) + name_of(info.param.partition);
}

class Schedules : public ::testing::TestWithParam<Case> {};

// At least a thousand interleavings in all, on one to three nodes; some networks are so slow that waves pass meanwhile.
TEST_P(Schedules, EndInTrueQuiescenceAndInTheGlobalDelaunayTriangulation) {
  const Case& c = GetParam();
  const HarnessReport report = run_harness(options_of(c));
  EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
  EXPECT_EQ(report.seeds, c.seeds);
  EXPECT_GT(report.sleeps, 0u);
  EXPECT_GT(report.spills, 0u);
  EXPECT_GT(report.waves, 2 * c.seeds);  // some first waves failed: messages were on their way
}
INSTANTIATE_TEST_SUITE_P(Clouds, Schedules,
                         ::testing::Values(Case{"lattice", 3, 40, 7, PartitionKind::kdtree, 400},
                                           Case{"lattice", 2, 40, 7, PartitionKind::random, 200},
                                           Case{"slab", 3, 60, 5, PartitionKind::octree, 150},
                                           Case{"corners", 3, 50, 8, PartitionKind::grid, 150},
                                           Case{"uniform", 2, 60, 12, PartitionKind::kdtree, 150},
                                           Case{"clusters", 3, 40, 6, PartitionKind::random, 100},
                                           Case{"jitter", 3, 40, 4, PartitionKind::kdtree, 100}),
                         name_of_case);

class PeriodicSchedules : public ::testing::TestWithParam<Case> {};

TEST_P(PeriodicSchedules, EndInTheTriangulationOfManyCopiesWhateverGoesWrong) {
  const Case& c = GetParam();
  HarnessOptions options = options_of(c);
  options.periodic = true;
  const HarnessReport report = run_harness(options);
  EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
  EXPECT_EQ(report.seeds, c.seeds);
  options.faults.storage = options.faults.kill = options.restarts = true;
  const HarnessReport faulty = run_harness(options);
  EXPECT_FALSE(faulty.failed_seed) << "seed " << *faulty.failed_seed << ": " << faulty.failure;
  EXPECT_EQ(faulty.seeds, c.seeds);
  EXPECT_GT(faulty.restarts, 0u);
}
INSTANTIATE_TEST_SUITE_P(Clouds, PeriodicSchedules,
                         ::testing::Values(Case{"lattice", 3, 40, 7, PartitionKind::kdtree, 60},
                                           Case{"lattice", 2, 40, 7, PartitionKind::random, 60},
                                           Case{"clusters", 3, 40, 6, PartitionKind::grid, 40},
                                           Case{"uniform", 2, 60, 12, PartitionKind::kdtree, 60}),
                         name_of_case);

class Accidents : public ::testing::TestWithParam<Case> {};

// Storage that fails or throws, memory that runs out, at the k-th call: the run ends with an error, never without an
// end; processes that are killed or cancelled at any step, scratch that is damaged meanwhile: what is resumed is right.
TEST_P(Accidents, EndInAnErrorAndWhatIsResumedIsTheGlobalDelaunayTriangulation) {
  const Case& c = GetParam();
  HarnessOptions options = options_of(c);
  options.faults.storage = options.restarts = true;
  const HarnessReport report = run_harness(options);
  EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
  EXPECT_EQ(report.seeds, c.seeds);
  EXPECT_GT(report.failures, c.seeds / 10);
  EXPECT_GT(report.restarts, c.seeds / 10 * 9);
  EXPECT_GT(report.nodes_lost, c.seeds / 50) << "whose scratch failed, and others went on";
  EXPECT_GT(report.settled_restarts, 0u);
  EXPECT_GT(report.mended, 0u);
}
INSTANTIATE_TEST_SUITE_P(Clouds, Accidents,
                         ::testing::Values(Case{"lattice", 3, 40, 7, PartitionKind::kdtree, 200},
                                           Case{"lattice", 2, 40, 7, PartitionKind::random, 300},
                                           Case{"lattice", 2, 30, 6, PartitionKind::kdtree, 300, 1001},
                                           Case{"uniform", 2, 60, 12, PartitionKind::kdtree, 200},
                                           Case{"planes", 2, 18, 7, PartitionKind::random, 300},
                                           Case{"clusters", 3, 40, 6, PartitionKind::random, 200}),
                         name_of_case);

class Losses : public ::testing::TestWithParam<Case> {};

// Nodes are killed, given up while they live, and come later, the coordinator is replaced, at any step and several
// times; some of those that were given up go on, and say what they have to say.
TEST_P(Losses, CostNoCell) {
  const Case& c = GetParam();
  HarnessOptions options = options_of(c);
  options.nodes = 3;
  options.faults.kill = options.faults.pause = options.faults.join = options.faults.coordinator = true;
  const HarnessReport report = run_harness(options);
  EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
  EXPECT_EQ(report.seeds, c.seeds);
  EXPECT_GT(report.epochs, c.seeds);
}
INSTANTIATE_TEST_SUITE_P(Clouds, Losses,
                         ::testing::Values(Case{"lattice", 3, 40, 7, PartitionKind::kdtree, 200},
                                           Case{"lattice", 2, 40, 7, PartitionKind::random, 300},
                                           Case{"planes", 2, 18, 7, PartitionKind::random, 300},
                                           Case{"clusters", 3, 40, 6, PartitionKind::random, 100},
                                           Case{"uniform", 2, 60, 12, PartitionKind::kdtree, 100}),
                         name_of_case);

class Leaving : public ::testing::TestWithParam<Case> {};

// Nodes leave in order, and others come: no tile begins again, which the harness looks at. Then coordinators are
// replaced, too, which changes nothing of that; then all else happens.
TEST_P(Leaving, CostsNoCellAndNoTile) {
  const Case& c = GetParam();
  for (const int more : {0, 1, 2}) {
    HarnessOptions options = options_of(c);
    options.nodes = 2 + static_cast<std::uint32_t>(c.seeds % 3);
    options.faults.leave = options.faults.join = true;
    options.faults.coordinator = more > 0;
    options.faults.kill = options.faults.pause = options.faults.last = options.faults.all = more > 1;
    const HarnessReport report = run_harness(options);
    EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
    EXPECT_EQ(report.seeds, c.seeds);
    EXPECT_GT(report.epochs, c.seeds / 2);
  }
}
INSTANTIATE_TEST_SUITE_P(Clouds, Leaving,
                         ::testing::Values(Case{"lattice", 3, 36, 7, PartitionKind::random, 102},
                                           Case{"planes", 2, 24, 7, PartitionKind::kdtree, 103},
                                           Case{"slab", 3, 40, 6, PartitionKind::kdtree, 101},
                                           Case{"clusters", 2, 36, 7, PartitionKind::random, 100},
                                           Case{"uniform", 3, 40, 9, PartitionKind::kdtree, 102}),
                         name_of_case);

// Of two nodes one is lost while they settle, and the other one is to leave: nobody takes the tiles of the first before
// a third has come, so that the second hands over without having heard of another table.
TEST(Harness, ANodeThatSettlesLeavesWhileAnotherIsLost) {
  HarnessOptions options = options_of({"planes", 2, 36, 7, PartitionKind::kdtree, 1, 261178602});
  options.nodes = 4;
  options.faults = {
      .kill = true, .pause = true, .join = true, .coordinator = true, .leave = true, .last = true, .all = true};
  const HarnessReport report = run_harness(options);
  EXPECT_FALSE(report.failed_seed) << report.failure;
  EXPECT_EQ(report.seeds, 1u);
}

class WithoutNodes : public ::testing::TestWithParam<Case> {};

// For a while no node is left: the job waits for one that comes, or is on its way, and for one that can open its share.
// First nothing else happens, then all that may.
TEST_P(WithoutNodes, CostsNoCell) {
  const Case& c = GetParam();
  for (const bool alone : {true, false}) {
    HarnessOptions options = options_of(c);
    options.nodes = 1 + static_cast<std::uint32_t>(c.seeds % 3);
    options.faults.last = options.faults.all = true;
    options.faults.kill = options.faults.pause = options.faults.join = options.faults.coordinator = !alone;
    const HarnessReport report = run_harness(options);
    EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
    EXPECT_EQ(report.seeds, c.seeds);
    EXPECT_GT(report.epochs, c.seeds / 2);
  }
}
INSTANTIATE_TEST_SUITE_P(Clouds, WithoutNodes,
                         ::testing::Values(Case{"lattice", 3, 36, 7, PartitionKind::kdtree, 102},
                                           Case{"planes", 2, 24, 7, PartitionKind::random, 103},
                                           Case{"corners", 2, 36, 7, PartitionKind::kdtree, 101},
                                           Case{"clusters", 3, 36, 6, PartitionKind::random, 100},
                                           Case{"uniform", 2, 40, 9, PartitionKind::kdtree, 102}),
                         name_of_case);

class TakingOver : public ::testing::TestWithParam<Case> {};

// Coordinators are stopped at any step, before anything is opened, too; those that were replaced go on. Nothing else
// happens to the first half of the seeds, and the nodes of the second are lost as well, or come.
TEST_P(TakingOver, CostsNoCell) {
  const Case& c = GetParam();
  for (const bool alone : {true, false}) {
    HarnessOptions options = options_of(c);
    options.nodes = 4;
    options.faults.coordinator = true;
    options.faults.kill = options.faults.pause = options.faults.join = !alone;
    const HarnessReport report = run_harness(options);
    EXPECT_FALSE(report.failed_seed) << "seed " << *report.failed_seed << ": " << report.failure;
    EXPECT_EQ(report.seeds, c.seeds);
    EXPECT_GT(report.epochs, c.seeds / 2);
  }
}
INSTANTIATE_TEST_SUITE_P(Clouds, TakingOver,
                         ::testing::Values(Case{"uniform", 3, 36, 7, PartitionKind::kdtree, 70, 4140},
                                           Case{"slab", 3, 36, 7, PartitionKind::random, 70, 5800},
                                           Case{"corners", 2, 36, 7, PartitionKind::kdtree, 70, 33600},
                                           Case{"planes", 2, 36, 7, PartitionKind::random, 70, 28600},
                                           Case{"clusters", 2, 36, 7, PartitionKind::kdtree, 70, 4960}),
                         name_of_case);

TEST(Harness, AnInterruptIsHeardWithinASeed) {
  HarnessOptions options;
  options.first_seed = 1;
  options.last_seed = 1'000'000;
  std::stop_source stop;
  options.stop = stop.get_token();
  std::uint64_t steps = 0;
  options.trace = [&](const std::string&) {
    if (++steps == 20) stop.request_stop();
  };
  const HarnessReport report = run_harness(options);
  EXPECT_FALSE(report.failed_seed);
  EXPECT_EQ(report.seeds, 0u);
}

TEST(Harness, TheSameSeedIsTheSameScheduleStepByStep) {
  HarnessOptions options;
  options.kind = "lattice";
  options.first_seed = options.last_seed = 17;
  std::vector<std::string> first, second, other;
  options.trace = [&](const std::string& line) { first.push_back(line); };
  EXPECT_FALSE(run_harness(options).failed_seed);
  options.trace = [&](const std::string& line) { second.push_back(line); };
  EXPECT_FALSE(run_harness(options).failed_seed);
  EXPECT_EQ(first, second);
  options.first_seed = options.last_seed = 18;
  options.trace = [&](const std::string& line) { other.push_back(line); };
  EXPECT_FALSE(run_harness(options).failed_seed);
  EXPECT_NE(first, other);
}

}  // namespace
}  // namespace tessera

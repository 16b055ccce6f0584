// Memory runs out at any allocation of a run of the real actors, one thread for all of them: in a tile's work, a part,
// a node, the coordinator, or while CAF sends a message.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "actors/harness/harness.h"
#include "src/base/memory_pool.h"
#include "tests/memory/failing_memory.h"
#include "tests/memory/runs.h"

namespace tessera::testing {
namespace {

struct Case {
  const char* kind;
  int dimension;
  std::size_t points;
  std::uint32_t tiles, nodes;
  PartitionKind partition;
  bool restarts;
};

std::string name_of_case(const ::testing::TestParamInfo<Case>& info) {
  const Case& c = info.param;
  return std::string(c.kind) + std::to_string(c.dimension) + name_of(c.partition) + (c.restarts ? "Restarts" : "");
}

// Only the code under test lacks memory.
class Faults final : public MemoryFaults {
 public:
  bool under_test(bool now) override { return !set_exempt(!now); }
  std::uint64_t failed() const override { return so_far().failed; }
};

class MemoryInHarness : public ::testing::TestWithParam<Case> {
 protected:
  MemoryInHarness() {
    const Case& c = GetParam();
    options_.kind = c.kind;
    options_.dimension = c.dimension;
    options_.points = c.points;
    options_.tiles = c.tiles;
    options_.nodes = c.nodes;
    options_.partition = c.partition;
    options_.restarts = c.restarts;
    options_.memory_faults = &faults_;
  }

  HarnessReport run(std::uint64_t seed, std::uint64_t first, std::uint64_t count, Allocations& seen) {
    options_.first_seed = options_.last_seed = seed;
    set_exempt(true);
    fail(first, count);
    HarnessReport report = run_harness(options_);
    seen = recover();
    set_exempt(false);
    return report;
  }

 private:
  Faults faults_;
  HarnessOptions options_;
  const MemoryPoolShare nothing_kept_{0};  // the pool keeps nothing: each of its allocations is one of the system's
};

// Whatever fails, once or several times in a row: the run ends, with an error that says so or rightly; and what is
// resumed is CGAL's triangulation. The harness compares.
TEST_P(MemoryInHarness, EndsTheRunWithAnErrorAndWhatIsResumedIsTheGlobalDelaunayTriangulation) {
  const std::uint64_t runs = runs_of(150);
  constexpr std::uint64_t seeds = 5;
  std::uint64_t failed = 0, ended = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Allocations all;
    const HarnessReport report = run(seed, 1, 0, all);
    ASSERT_FALSE(report.failed_seed) << "seed " << seed << ": " << report.failure;
    const std::uint64_t tries = std::min(runs / seeds, all.asked);
    for (std::uint64_t i = 0; i < tries; ++i) {
      const std::uint64_t first = 1 + i * all.asked / tries;
      const std::uint64_t count = in_a_row[(i + seed) % std::size(in_a_row)];
      SCOPED_TRACE("seed " + std::to_string(seed) + ", allocations " + std::to_string(first) + " to " +
                   std::to_string(first + count - 1) + " of " + std::to_string(all.asked) + " fail");
      Allocations seen;
      const HarnessReport with = run(seed, first, count, seen);
      ASSERT_FALSE(with.failed_seed) << with.failure;
      EXPECT_GT(seen.failed, 0u);
      failed += seen.failed;
      ended += with.failures;
    }
  }
  RecordProperty("allocations that failed", std::to_string(failed));
  EXPECT_GT(ended, runs / 2);
}
INSTANTIATE_TEST_SUITE_P(Clouds, MemoryInHarness,
                         ::testing::Values(Case{"lattice", 3, 40, 7, 3, PartitionKind::kdtree, false},
                                           Case{"lattice", 2, 40, 7, 2, PartitionKind::random, false},
                                           Case{"uniform", 2, 60, 12, 3, PartitionKind::kdtree, true},
                                           Case{"clusters", 3, 40, 6, 2, PartitionKind::grid, true},
                                           Case{"corners", 3, 50, 8, 1, PartitionKind::octree, false}),
                         name_of_case);

}  // namespace
}  // namespace tessera::testing

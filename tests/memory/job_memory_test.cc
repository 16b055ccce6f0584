// Memory runs out at any allocation of a whole job with threads and a disk: while points are read and routed, in the
// actors, the writers of meshes, or the manifest.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/base/memory_pool.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "src/job/job.h"
#include "src/job/open_cloud.h"
#include "src/result/tile_source.h"
#include "src/tiling/budget/budget.h"
#include "tests/engine/sets.h"
#include "tests/memory/failing_memory.h"
#include "tests/memory/runs.h"

namespace tessera::testing {
namespace {

constexpr std::uint32_t threads = 3, tiles = 6;
constexpr std::size_t points = 900, points_a_file = 250;
constexpr std::uint64_t memory_bytes = std::uint64_t{1} << 30;

struct Case {
  const char* name;
  int dimension;
  bool short_of_memory;  // tiles are reduced, and sleep
  KernelKind kernel;
};

class MemoryInJob : public ::testing::TestWithParam<Case> {
 protected:
  MemoryInJob() {
    const Case& c = GetParam();
    auto cloud = make_cloud("uniform", c.dimension, points, 1);
    cloud.insert(cloud.end(), cloud.begin(), cloud.begin() + 30);  // duplicates
    std::vector<double> coordinates;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud[i].id = PointId{i};
      const Point& at = cloud[i].at;
      coordinates.insert(coordinates.end(), {at.x, at.y});
      if (c.dimension == 3) coordinates.push_back(at.z);
      if (i + 1 < cloud.size() && (i + 1) % points_a_file != 0) continue;
      inputs_.push_back((scratch_.path() / (std::to_string(inputs_.size()) + ".npy")).string());
      EXPECT_TRUE(write_npy(inputs_.back(), c.dimension, coordinates));
      coordinates.clear();
    }
    cells_ = global_delaunay(cloud, c.dimension);
    options_.tiles = tiles;
    options_.threads = options_.cloud.threads = threads;
    options_.cloud.dimension = c.dimension;
    options_.kernel = c.kernel;
    options_.memory_bytes = memory_bytes;
    if (c.short_of_memory) {
      options_.keep = TileRetention::reduced;
      // The least that is accepted.
      const std::uint64_t points = cloud.size() / tiles + 1;
      for (options_.memory_bytes = 1 << 20;
           !budget::tile_fits(c.dimension, c.kernel, points, tiles, threads, options_.memory_bytes);)
        options_.memory_bytes += 1 << 20;
    }
  }

  // "" or what is wrong with the result.
  std::string wrong() const {
    const auto source = TileSource::open(out_);
    if (!source) return source.error().where;
    std::vector<TileMesh> meshes;
    for (std::size_t i = 0; i < source.value().tiles(); ++i) {
      auto tile = source.value().read(i, {});
      if (!tile) return tile.error().where;
      meshes.push_back(std::move(tile.value().mesh));
    }
    return difference(cells_, main_cells(meshes));
  }

  // A job, or its continuation, in which allocations fail. Nothing when it has succeeded.
  std::optional<Error> run(bool resume, bool abandon, std::uint64_t first, std::uint64_t count, Allocations& seen) {
    auto folder = ResultFolder::inspect(out_, resume, false);
    if (!folder) return folder.error();
    Progress progress;
    const OpenCloud open = [&](JobOptions& job, const std::stop_token& stop) { return open_cloud(inputs_, job, stop); };
    fail(first, count);
    const auto made = run_job(engine_, options_, open, folder.value(), progress, {});
    seen = recover();
    if (made) return std::nullopt;
    if (abandon) folder.value().abandon();
    return made.error();
  }

  void remove_result() { std::filesystem::remove_all(out_); }

  const TemporaryFolder scratch_ = TemporaryFolder::make().value();
  const std::filesystem::path out_ = scratch_.path() / "out";

 private:
  Engine engine_{threads, memory_bytes};  // one for all runs: each leaves it as it was
  std::vector<std::string> inputs_;
  JobOptions options_;
  std::vector<IdCell> cells_;
  const MemoryPoolShare nothing_kept_{0};  // the pool keeps nothing: each of its allocations is one of the system's
};

// Whatever fails, once or several times in a row: the job ends, with an error that says so or rightly; what is resumed,
// after one such end or two, is CGAL's triangulation; and what is given up leaves nothing.
TEST_P(MemoryInJob, EndsTheJobWithAnErrorAndWhatIsResumedIsTheGlobalDelaunayTriangulation) {
  Allocations all;
  const auto never = run(false, false, 1, 0, all);
  ASSERT_FALSE(never) << never->where;
  ASSERT_EQ(wrong(), "");
  std::mt19937_64 rng(1);
  const std::uint64_t runs = runs_of(40);
  std::uint64_t failed = 0, ended = 0;
  for (std::uint64_t i = 0; i < runs; ++i) {
    remove_result();
    bool done = false;
    for (int life = 0; !done; ++life) {
      const std::uint64_t first = 1 + rng() % all.asked;
      const std::uint64_t count = life < 2 ? in_a_row[rng() % std::size(in_a_row)] : 0;
      SCOPED_TRACE("run " + std::to_string(i) + ", life " + std::to_string(life) + ", allocations " +
                   std::to_string(first) + " to " + std::to_string(first + count - 1) + " of some " +
                   std::to_string(all.asked) + " fail");
      const bool abandon = life == 0 && rng() % 4 == 0;
      Allocations seen;
      const auto error = run(life > 0, abandon, first, count, seen);
      failed += seen.failed;
      if (error) {
        ASSERT_EQ(error->code, Errc::memory) << error->where;
        ASSERT_GT(seen.failed, 0u);
        ++ended;
      }
      done = !error || abandon;
      if (!error) {
        ASSERT_EQ(wrong(), "");
      } else if (abandon && std::filesystem::exists(out_)) {
        ASSERT_EQ(wrong(), "");  // it was complete
      }
    }
  }
  RecordProperty("allocations that failed", std::to_string(failed));
  EXPECT_GT(ended, runs / 2);
}
TEST(MemoryInFolders, LeavesNoneThatNobodyOwns) {
  const TemporaryFolder parent = TemporaryFolder::make().value();
  const auto named = parent.path() / "a folder with a name that is not kept in the string itself";
  int refused = 0;
  for (std::uint64_t first = 1; first < 30; ++first) {
    fail(first, 1000);
    try {
      const auto made = TemporaryFolder::make(named);
      recover();
      EXPECT_TRUE(made);
    } catch (const std::bad_alloc&) {
      recover();
      ++refused;
    }
    EXPECT_FALSE(std::filesystem::exists(named)) << first;
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, 29);
}

INSTANTIATE_TEST_SUITE_P(Jobs, MemoryInJob,
                         ::testing::Values(Case{"Whole3", 3, false, KernelKind::flat},
                                           Case{"Short3", 3, true, KernelKind::flat},
                                           Case{"Short2", 2, true, KernelKind::flat},
                                           Case{"Cgal3", 3, false, KernelKind::cgal}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace tessera::testing

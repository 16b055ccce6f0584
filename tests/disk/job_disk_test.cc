// A whole job, and its continuations, on a disk that fails at any call below the result folder.
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/geometry/reference/clouds.h"
#include "src/geometry/reference/reference.h"
#include "src/job/job.h"
#include "src/job/open_cloud.h"
#include "src/result/tile_source.h"
#include "tests/disk/failing_disk.h"
#include "tests/engine/sets.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t threads = 2, tiles = 5;
constexpr std::uint64_t memory_bytes = std::uint64_t{1} << 30;

class JobDisk : public ::testing::Test {
 protected:
  JobDisk() {
    auto cloud = make_cloud("uniform", 3, 400, 1);
    std::vector<double> coordinates;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud[i].id = PointId{i};
      const Point& at = cloud[i].at;
      coordinates.insert(coordinates.end(), {at.x, at.y, at.z});
    }
    EXPECT_TRUE(write_npy(input_, 3, coordinates));
    cells_ = global_delaunay(cloud, 3);
    options_.tiles = tiles;
    options_.threads = options_.cloud.threads = threads;
    options_.memory_bytes = memory_bytes;
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

  // A job, or its continuation, on a disk that fails. Nothing when it has succeeded.
  std::optional<Error> run(bool resume, std::uint64_t first, std::uint64_t count, int number, DiskCalls& seen) {
    fail_below(out_, first, count, number);
    auto folder = ResultFolder::inspect(out_, resume, false);
    if (!folder) {
      seen = recover_disk();
      return folder.error();
    }
    Progress progress;
    const OpenCloud open = [&](JobOptions& job, const std::stop_token& stop) {
      return open_cloud({input_}, job, stop);
    };
    const auto made = run_job(engine_, options_, open, folder.value(), progress, {});
    seen = recover_disk();
    return made ? std::nullopt : std::optional(made.error());
  }

  bool is_routed() const { return fs::exists(plan_file(run_folder(out_))); }
  bool is_complete() const { return fs::exists(manifest_file(out_)); }

  const TemporaryFolder scratch_ = TemporaryFolder::make().value();
  const fs::path out_ = scratch_.path() / "out";

 private:
  Engine engine_{threads, memory_bytes};
  const std::string input_ = (scratch_.path() / "in.npy").string();
  JobOptions options_;
  std::vector<IdCell> cells_;
};

// Whatever fails, once or from then on: the job ends, with an error that says so or rightly; what was routed stays; and
// what is resumed is CGAL's triangulation.
TEST_F(JobDisk, ATroubleWithItAtAnyCallEndsTheJobWithAnErrorAndWhatIsResumedIsRight) {
  DiskCalls all;
  const auto never = run(false, 1, 0, EIO, all);
  ASSERT_FALSE(never) << never->where;
  ASSERT_EQ(wrong(), "");
  ASSERT_GT(all.asked, 200u);
  std::mt19937_64 rng(1);
  constexpr int runs = 120;
  int ended = 0, kept = 0;
  for (int i = 0; i < runs; ++i) {
    fs::remove_all(out_);
    bool done = false;
    for (int life = 0; !done; ++life) {
      const std::uint64_t first = 1 + rng() % all.asked;
      const std::uint64_t count = life > 2 ? 0 : rng() % 2 == 0 ? 1 : 1'000'000;
      const int number = disk_errors[rng() % std::size(disk_errors)];
      SCOPED_TRACE("run " + std::to_string(i) + ", life " + std::to_string(life) + ", from call " +
                   std::to_string(first) + " on " + std::to_string(count) + " fail with " +
                   std::generic_category().message(number));
      const bool routed = is_routed(), complete = is_complete();
      DiskCalls seen;
      const auto error = run(life > 0, first, count, number, seen);
      if (error) {
        ASSERT_EQ(error->code, Errc::io) << error->where;
        ASSERT_GT(seen.failed, 0u) << error->where;
        ASSERT_TRUE(!routed || is_routed() || is_complete()) << "the run is gone: " << error->where;
        ASSERT_TRUE(!complete || is_complete()) << "the result is gone: " << error->where;
        ++ended;
        kept += routed ? 1 : 0;
      }
      done = !error;
    }
    ASSERT_EQ(wrong(), "");
  }
  EXPECT_GT(ended, runs / 2);
  EXPECT_GT(kept, 10);
}

}  // namespace
}  // namespace tessera::testing

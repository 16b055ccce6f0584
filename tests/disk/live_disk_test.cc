// A result in memory on a disk that fails at any call: what apply() has returned for is there when the result is opened
// again, what was refused is not, and nothing happens twice.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/delaunay/live/live_result.h"
#include "src/service/live/kept_live.h"
#include "tests/disk/failing_disk.h"
#include "tests/live/live_model.h"
#include "tests/store/sample_result.h"

namespace tessera::testing {
namespace {

namespace fs = std::filesystem;

const LiveOptions options{.tile_points = 8};  // so that versions split tiles

class LiveDisk : public ::testing::Test {
 protected:
  LiveDisk() { model_.store(kept_); }
  void copy() {
    fs::remove_all(folder_);
    fs::copy(kept_, folder_, fs::copy_options::recursive);
  }
  // Batches and versions. Returns whether it is known what is there, and `model` is that.
  bool work(LiveModel& model) const {
    const auto live = LiveResult::open(folder_, options);
    if (!live) return true;
    for (int k = 0; k < 4; ++k) {
      const ResultChange change = model.next();
      const bool allowed = model.allows(change);
      const auto applied = live.value()->apply(change);
      if (!applied && live.value()->state().broken) return false;
      EXPECT_TRUE(applied.has_value() || !allowed ||
                  applied.error().where.find("nothing has changed") != std::string::npos)
          << applied.error().where;
      if (applied) {
        model.apply(change);
      } else {
        model.skip();
      }
      if (k % 2 == 1 && !live.value()->checkpoint() && live.value()->state().broken) return true;
    }
    return true;
  }

  const test::TemporaryFolder scratch_;
  const fs::path kept_ = scratch_.path() / "kept", folder_ = scratch_.path() / "out";
  LiveModel model_{{.kind = "lattice", .dimension = 2, .tiles = 4, .grows = true}, 60, 11};
};

TEST_F(LiveDisk, HasWhatWasAnsweredAndNothingThatWasRefused) {
  std::uint64_t calls = 0, unknown = 0;
  for (const std::uint64_t count : {std::uint64_t{1}, std::uint64_t{1'000'000}}) {
    bool all = false;
    for (std::uint64_t first = 1; !all; ++first, ++calls) {
      copy();
      LiveModel model = model_;
      const int number = disk_errors[first % std::size(disk_errors)];
      SCOPED_TRACE("call " + std::to_string(first) + (count > 1 ? " and those after it fail" : " fails") + " with " +
                   std::generic_category().message(number));
      fail_below(folder_, first, count, number);
      const bool known = work(model);
      all = recover_disk().failed == 0;
      const auto again = LiveResult::open(folder_, options);
      ASSERT_TRUE(again) << again.error().where;
      const auto now = again.value()->current();
      if (known || !model.compare(*now).empty()) {
        if (!known) {  // the batch of which nothing is known is there as a whole
          model.go_on();
          ++unknown;
        }
        ASSERT_EQ(model.compare(*now), "");
      }
      const Status made = again.value()->checkpoint();
      ASSERT_TRUE(made) << made.error().where;
    }
  }
  EXPECT_GT(calls, 100u);
  EXPECT_GT(unknown, 0u);
}

// Between any two calls, also while a version is stored whose tiles are split.
TEST_F(LiveDisk, LosesNothingWhenItsProcessIsKilledAtAnyCall) {
  std::uint64_t calls = 0, unknown = 0;
  std::size_t least = 1000, most = 0;  // tiles
  for (bool all = false; !all; ++calls) {
    SCOPED_TRACE("killed at call " + std::to_string(calls + 1));
    copy();
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      LiveModel model = model_;
      fail_below(folder_, calls + 1, 1, kill_process);
      const auto live = LiveResult::open(folder_, options);
      for (int k = 0; k < 4; ++k) {
        if (live.value()->apply(model.next()).has_value() != model.go_on()) ::_exit(2);
        const std::uint64_t version = model.version();
        if (::write(ends[1], &version, sizeof version) != sizeof version) ::_exit(3);
        if (k % 2 == 1 && !live.value()->checkpoint()) ::_exit(4);
      }
      ::_exit(0);
    }
    ::close(ends[1]);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    all = WIFEXITED(status);
    ASSERT_TRUE(!all || WEXITSTATUS(status) == 0) << WEXITSTATUS(status);
    LiveModel model = model_;
    std::uint64_t answered = 0;
    while (::read(ends[0], &answered, sizeof answered) == sizeof answered) {
    }
    ::close(ends[0]);
    while (model.version() < answered) model.go_on();
    const auto again = LiveResult::open(folder_, options);
    ASSERT_TRUE(again) << again.error().where;
    if (!model.compare(*again.value()->current()).empty()) {  // the batch that was not answered for is there
      while (!model.go_on()) {
      }
      ++unknown;
      ASSERT_EQ(model.compare(*again.value()->current()), "");
    }
    const std::size_t tiles = again.value()->current()->tiles().size();
    least = std::min(least, tiles);
    most = std::max(most, tiles);
    const Status made = again.value()->checkpoint();
    ASSERT_TRUE(made) << made.error().where;
    EXPECT_EQ(model.compare(*again.value()->current()), "");
  }
  EXPECT_GT(calls, 100u);
  EXPECT_GT(unknown, 0u);
  EXPECT_EQ(least, 4u);
  EXPECT_GT(most, 8u);  // some were killed before, some after a version with split tiles
  std::cout << "figures: killed at " << calls << " calls; " << unknown << " times one more batch was in the log\n";
}

// Requests that come at once are one batch. When it is not known whether the log has the batch, they are not tried one
// by one: they would be there twice.
TEST_F(LiveDisk, AppliesNothingTwice) {
  copy();
  const auto kept = service::KeptLive::open(folder_, {.live = options});
  ASSERT_TRUE(kept) << kept.error().where;
  const std::uint64_t vertices = kept.value()->current()->vertices();
  std::uint64_t together = 0;
  for (int round = 0; round < 8; ++round) {
    // A first batch takes so long that the others come meanwhile.
    ResultChange slow;
    for (int k = 0; k < 3000; ++k) slow.add.push_back({0.001 + 0.0001 * round, 0.001 + 0.003 * k, 0});
    std::vector<std::optional<Result<proto::PointsChanged>>> done(7);
    fail_below(folder_, 4, 1, EIO);  // the second batch is written to the log, and the sync fails
    {
      std::vector<std::jthread> callers;
      for (std::size_t i = 0; i < done.size(); ++i)
        callers.emplace_back([&, i] {
          const ResultChange one{.add = {{0.501 + 0.01 * round, 0.001 + 0.1 * static_cast<double>(i), 0}}};
          done[i] = kept.value()->change(i == 0 ? slow : one, EqualToNew::stay, {});
        });
    }
    recover_disk();
    std::uint64_t refused = 0;
    for (const auto& one : done) {
      refused += *one ? 0 : 1;
      EXPECT_TRUE(!*one || one->value().equal() == 0) << "a point is there a second time";
    }
    together += refused > 1 ? 1 : 0;
  }
  EXPECT_GT(together, 0u);
  const auto last = kept.value()->change({.add = {{0.5, -7.25, 0}}}, EqualToNew::stay, {});  // opens the result again
  ASSERT_TRUE(last) << last.error().where;
  const auto now = kept.value()->current();
  EXPECT_EQ(now->ids().size() - now->vertices(), 40 - vertices) << "a point is there a second time";
}

}  // namespace
}  // namespace tessera::testing

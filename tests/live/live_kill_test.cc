// What apply() has returned for survives kill -9 at any moment, and nothing is half there.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <random>

#include "src/delaunay/live/live_result.h"
#include "src/result/tile_source.h"
#include "tests/live/live_model.h"
#include "tests/store/sample_result.h"

namespace tessera::testing {
namespace {

// Tiles are soon too large, so that many versions of the result split some.
const LiveOptions options{.tile_points = 8};

// Applies batch after batch, and tells of each; now and then makes a new version of the result. Never returns.
[[noreturn]] void work(const std::filesystem::path& folder, LiveModel model, int tell) {
  const auto live = LiveResult::open(folder, options);
  if (!live) ::_exit(2);
  for (;;) {
    const bool applied = live.value()->apply(model.next()).has_value();
    if (model.go_on() != applied) ::_exit(3);
    const std::uint64_t version = model.version();
    if (::write(tell, &version, sizeof version) != sizeof version) ::_exit(4);
    if (version % 3 == 0 && !live.value()->checkpoint()) ::_exit(5);
  }
}

TEST(LiveKilled, LosesNothingThatWasAnsweredAndHasNothingByHalves) {
  const test::TemporaryFolder scratch;
  const auto folder = scratch.path() / "out";
  LiveModel model({.kind = "lattice", .dimension = 2, .tiles = 4, .grows = true}, 40, 11);
  model.store(folder);
  std::mt19937_64 rng(1);
  std::uint64_t answered_in_all = 0, beyond = 0;
  for (int k = 0; k < 200; ++k) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) work(folder, model, ends[1]);
    ::close(ends[1]);
    std::uint64_t answered = model.version(), version = 0;
    const std::uint64_t wanted = 1 + rng() % 4;
    for (std::uint64_t n = 0; n < wanted && ::read(ends[0], &version, sizeof version) == sizeof version; ++n)
      answered = version;
    for (volatile std::uint64_t spin = rng() % 400'000; spin > 0;) spin = spin - 1;  // up to a millisecond
    ::kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << "it ended by itself: " << WEXITSTATUS(status);
    while (::read(ends[0], &version, sizeof version) == sizeof version) answered = version;
    ::close(ends[0]);

    const auto live = LiveResult::open(folder, options);
    ASSERT_TRUE(live) << live.error().where;
    const auto now = live.value()->current();
    answered_in_all += answered - model.version();
    while (model.version() < answered) model.go_on();
    if (model.compare(*now).empty()) continue;
    // The batch that was not answered for is there as a whole. Batches that are refused are not there to be seen.
    while (!model.go_on()) {
    }
    ++beyond;
    ASSERT_EQ(model.compare(*now), "") << "after end " << k;
  }
  const auto source = TileSource::open(folder);
  ASSERT_TRUE(source) << source.error().where;
  const std::size_t tiles = source.value().manifest().boxes.size();
  EXPECT_GT(tiles, 12u) << "hardly a tile was split";
  std::cout << "figures: " << tiles << " tiles in the end, 4 in the beginning; " << answered_in_all
            << " batches were answered, " << beyond << " times one more was in the log\n";
}

}  // namespace
}  // namespace tessera::testing

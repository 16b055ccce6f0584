// What a forked child may do with the library, and what it is told when it may not.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "tests/api/api_testing.h"
#include "tests/api/temporary_home.h"

namespace tessera {
namespace {

using testing::cloud;
using testing::failure_of;
using testing::TemporaryHome;

// What a forked child writes to its parent: the text that `work` returns, or what it throws. A child that hangs is
// ended by its alarm, and then says nothing.
std::string said_by_child(const std::function<std::string()>& work) {
  int ends[2];
  EXPECT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::alarm(60);
    std::string said;
    try {
      said = work();
    } catch (const std::exception& thrown) {
      said = thrown.what();
    }
    const auto written = ::write(ends[1], said.data(), said.size());
    ::_exit(written == static_cast<ssize_t>(said.size()) ? 0 : 1);
  }
  ::close(ends[1]);
  std::string said;
  char part[256];
  for (ssize_t n = 0; (n = ::read(ends[0], part, sizeof part)) > 0;) said.append(part, static_cast<std::size_t>(n));
  ::close(ends[0]);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "the child hung or broke";
  return said;
}

TriangulationOptions small_tiles() {
  TriangulationOptions options;
  options.max_points_per_tile(300);
  options.threads(2);
  return options;
}

TEST(AForkedChild, UsesTheLibraryAsItsParentDoes) {
  const TemporaryHome home;
  const auto points = cloud("lattice", 3, 2000);
  const auto t = triangulate(points, small_tiles());
  const Delaunay whole(points, 3);
  const auto cells = testing::cells_of(t);
  EXPECT_EQ(said_by_child([&] {
              const bool same = testing::cells_of(t) == cells && testing::cells_of(Delaunay(points, 3)) == cells &&
                                testing::cells_of(whole) == cells;
              return same && triangulate(points, small_tiles()).digest() == t.digest() ? "the same" : "another";
            }),
            "the same");
}

TEST(AForkedChild, LeavesItsParentsTemporaryResultAlone) {
  const TemporaryHome home;
  std::optional<Triangulation> t = triangulate(cloud("uniform", 3, 100), small_tiles());
  EXPECT_EQ(said_by_child([&] {
              t.reset();
              return "dropped";
            }),
            "dropped");
  EXPECT_EQ(t->tile(0).dimension(), 3);
  EXPECT_EQ(home.entries(), 1u);
  t.reset();
  EXPECT_EQ(home.entries(), 0u);
}

constexpr const char* refused = "this process was forked while its parent was in a call of this library";

// Begins with `refused`, whatever is called; what is at hand stays good, and may be destroyed.
std::string calls_in_child(std::optional<Triangulation>& t, std::optional<Delaunay>& whole) {
  const std::vector<double> points{0, 0, 1, 0, 0, 1};
  TriangulationOptions options;
  options.dimension(2);
  std::vector<std::int32_t> out(1);
  const std::function<void()> calls[] = {[&] { triangulate(points, options); },
                                         [&] { Delaunay(points, 2); },
                                         [&] {
                                           whole->find_simplex(std::vector<double>{0, 0, 0}, out);
                                         },
                                         [&] { t->tile(0); },
                                         [&] { t->export_to("/nowhere/mesh.ply"); },
                                         [&] { Triangulation::open("/nowhere"); }};
  for (const auto& call : calls) {
    const auto failure = failure_of(call);
    if (failure.cause() != Cause::usage || std::string(failure.what()).find(refused) != 0) return failure.what();
  }
  if (t->cells() == 0 || whole->simplices().empty()) return "the results are gone";
  t.reset();
  whole.reset();
  return "refused";
}

class AChildForkedWithinACall : public ::testing::Test {
 protected:
  const TemporaryHome home_;
  std::optional<Triangulation> t_ = triangulate(cloud("uniform", 3, 2000), small_tiles());
  std::optional<Delaunay> whole_{std::in_place, cloud("uniform", 3, 2000), 3};
};

TEST_F(AChildForkedWithinACall, OfAnotherThreadIsRefusedAtOnce) {
  std::mutex mutex;
  std::condition_variable changed;
  bool working = false, forked = false;
  auto options = small_tiles();
  options.progress([&](const JobProgress&) {
    std::unique_lock lock(mutex);
    working = true;
    changed.notify_all();
    changed.wait(lock, [&] { return forked; });
  });
  const auto points = cloud("uniform", 3, 50'000);
  std::jthread other([&] { EXPECT_EQ(triangulate(points, options).vertices(), 50'000u); });
  {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return working; });
  }
  const auto said = said_by_child([&] { return calls_in_child(t_, whole_); });
  {
    const std::lock_guard lock(mutex);
    forked = true;
  }
  changed.notify_all();
  EXPECT_EQ(said, "refused");
}

TEST_F(AChildForkedWithinACall, ByItsCallbackIsRefusedAndLeavesTheJobToItsParent) {
  auto options = small_tiles();
  options.folder(home_.path() / "out");
  std::string said;
  options.progress([&](const JobProgress&) {
    if (said.empty()) said = said_by_child([&] { return calls_in_child(t_, whole_); });
  });
  EXPECT_EQ(triangulate(cloud("uniform", 3, 50'000), options).vertices(), 50'000u);
  EXPECT_EQ(said, "refused");
}

TEST_F(AChildForkedWithinACall, MayReturnFromTheCallback) {
  auto options = small_tiles();
  options.folder(home_.path() / "out");
  bool is_child = false, forked = false;
  options.progress([&](const JobProgress&) {
    if (forked) return;
    forked = true;
    is_child = ::fork() == 0;
    if (is_child) ::alarm(60);
  });
  const auto points = cloud("uniform", 3, 50'000);
  try {
    EXPECT_EQ(triangulate(points, options).vertices(), 50'000u);
    if (is_child) ::_exit(1);
  } catch (const Failure& failure) {
    ::_exit(is_child && std::string(failure.what()).find(refused) == 0 ? 0 : 1);
  }
  int status = 0;
  ::wait(&status);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "the child hung, or was not refused";
  EXPECT_EQ(Triangulation::open(home_.path() / "out").vertices(), 50'000u);
}

}  // namespace
}  // namespace tessera

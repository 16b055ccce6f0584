#include "src/service/staging_folder.h"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "src/base/files/names.h"
#include "tests/service/service_testing.h"

namespace tessera::service {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class DeskTest : public ::testing::Test {
 protected:
  DeskTest() {
    fs::create_directories(area() / "old" / "exports");
    std::ofstream(area() / "old" / "manifest.json") << "old";
    fs::create_directory(area() / "made");
    std::ofstream(area() / "made" / "manifest.json") << "made";
  }
  fs::path area() const { return folder_.path(); }

  // Of a process that never doubts that the lock is its own: as one that stands still after its last look.
  std::unique_ptr<StagingFolder> lay(std::uint64_t term) const {
    auto desk = StagingFolder::lay(area(), term, [] { return success(); });
    EXPECT_TRUE(desk) << desk.error().where;
    return std::move(desk).value();
  }
  // Every file, with what is in it.
  std::map<std::string, std::string> all() const {
    std::map<std::string, std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(area()))
      if (entry.is_regular_file()) found[entry.path().lexically_relative(area()).string()] = content(entry.path());
    return found;
  }

  const TemporaryFolder folder_ = testing::temporary_folder();
};

TEST_F(DeskTest, WritesAndMovesAndLeavesNothing) {
  {
    const auto desk = lay(1);
    EXPECT_EQ(desk->term(), 1u);
    ASSERT_TRUE(desk->write(area() / "old" / "note", "first"));
    ASSERT_TRUE(desk->write(area() / "old" / "note", "second"));
    ASSERT_TRUE(desk->move(area() / "made", area() / "new"));
    EXPECT_FALSE(desk->move(area() / "nothing", area() / "other"));
  }
  EXPECT_EQ(all(), (std::map<std::string, std::string>{
                       {"new/manifest.json", "made"}, {"old/manifest.json", "old"}, {"old/note", "second"}}));
  EXPECT_FALSE(fs::exists(staging_folder_path(area(), 1)));
}

// A result that is replaced, in its steps; a successor comes before each of them.
TEST_F(DeskTest, NoStepOfAnEarlierTermCountsOnceALaterOneHasBegun) {
  const auto before = all();
  for (int steps = 0; steps < 4; ++steps) {
    const auto early = lay(2 * static_cast<std::uint64_t>(steps) + 1);
    fs::path old, made;
    const auto step = [&](int number) -> Status {
      if (number == 0) {
        BOOST_OUTCOME_TRY(up, early->pick_up(area() / "old"));
        old = up;
      } else if (number == 1) {
        BOOST_OUTCOME_TRY(up, early->pick_up(area() / "made"));
        made = up;
      } else if (number == 2) {
        return early->put_down(made, area() / "old");
      } else {
        return early->put_down(old, removed_folder(area(), "x"));
      }
      return success();
    };
    for (int i = 0; i < steps; ++i) ASSERT_TRUE(step(i));
    const auto late = lay(early->term() + 1);
    const auto at_takeover = all();
    for (int i = steps; i < 4; ++i) EXPECT_FALSE(step(i)) << steps << ", " << i;
    EXPECT_FALSE(early->write(area() / "old" / "manifest.json", "of an earlier term"));
    EXPECT_FALSE(early->move(area() / "old", area() / "elsewhere"));
    EXPECT_EQ(all(), at_takeover);
    if (steps < 3) {
      EXPECT_EQ(at_takeover, before) << steps;  // what was on its way is back
    } else {                                    // the new one stands there, and the old one waits to be removed
      EXPECT_EQ(at_takeover.at("old/manifest.json"), "made");
      EXPECT_FALSE(at_takeover.contains("made/manifest.json"));
    }
  }
}

// Whenever the successor comes, from the moment on when its desk is laid nothing changes by the other's hand.
TEST_F(DeskTest, NothingIsChangedByAProcessWhoseTimeIsOverHoweverBusyItIs) {
  for (std::uint64_t round = 0; round < 100; ++round) {
    auto early = lay(2 * round + 1);
    std::atomic<bool> over = false, at_work = false;
    std::jthread busy([&] {
      for (int i = 0; !over; ++i) {
        static_cast<void>(early->write(area() / "old" / "note", std::to_string(i)));
        if (early->move(area() / "made", area() / "new"))
          static_cast<void>(early->move(area() / "new", area() / "made"));
        at_work = true;
      }
    });
    while (!at_work) std::this_thread::yield();
    const auto late = lay(2 * round + 2);
    const auto at_takeover = all();
    for (int i = 0; i < 3; ++i) EXPECT_EQ(all(), at_takeover);
    over = true;
    busy.join();
    EXPECT_EQ(all(), at_takeover);
    EXPECT_TRUE(at_takeover.contains("made/manifest.json") != at_takeover.contains("new/manifest.json"));
    if (at_takeover.contains("new/manifest.json")) {
      ASSERT_TRUE(late->move(area() / "new", area() / "made"));
    }
  }
}

TEST_F(DeskTest, AsksFirstAndTellsWhyItIsNotItsTurnAnyMore) {
  bool ours = true;
  auto desk = StagingFolder::lay(area(), 1, [&]() -> Status {
    if (ours) return success();
    return error(Errc::io, "the folder is another's");
  });
  ASSERT_TRUE(desk);
  ours = false;
  EXPECT_EQ(desk.value()->write(area() / "note", "x").error().where, "the folder is another's");
  EXPECT_EQ(desk.value()->move(area() / "old", area() / "new").error().where, "the folder is another's");
  EXPECT_FALSE(StagingFolder::lay(area(), 2, [] { return Status(error(Errc::io, "lost meanwhile")); }));
  EXPECT_EQ(all().size(), 2u);
}

TEST_F(DeskTest, OfAnEarlierTermWithStrangeThingsIsAnErrorAndIsLeftAlone) {
  const auto strange = staging_folder_path(area(), 1) / "somebody's";
  fs::create_directory(strange.parent_path());
  std::ofstream(strange) << "x";
  const auto desk = StagingFolder::lay(area(), 2, [] { return success(); });
  ASSERT_FALSE(desk);
  EXPECT_EQ(desk.error().code, Errc::corrupt);
  EXPECT_NE(desk.error().where.find("somebody's"), std::string::npos);
  EXPECT_TRUE(fs::exists(strange));
}

}  // namespace
}  // namespace tessera::service

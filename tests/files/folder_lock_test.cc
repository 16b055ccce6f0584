#include "src/base/files/folder_lock.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <barrier>
#include <fstream>
#include <functional>
#include <thread>
#include <vector>

#include "src/base/files/lock_owner.h"
#include "src/base/files/names.h"
#include "tests/files/files_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class Lock : public FolderFixture {
 protected:
  // The lock of somebody who is not there to hold it.
  void leave_lock_of(const LockOwner& owner) const {
    ASSERT_TRUE(fs::create_directory(lock_folder(folder())));
    std::ofstream file(lock_folder(folder()) / owner.name());
    ASSERT_TRUE(file);
  }

  void expect_refused(const LockOptions& options, const LockOwner& by) const {
    const auto lock = FolderLock::take(folder(), options);
    ASSERT_FALSE(lock);
    EXPECT_EQ(lock.error().code, Errc::usage);
    EXPECT_EQ(lock.error().where, folder().string() + ": another tessera is at work in it: process " +
                                      std::to_string(by.process) + " on " + by.host);
  }

  fs::path owner_file() const { return fs::directory_iterator(lock_folder(folder()))->path(); }
};

LockOwner of_another_host() {
  auto owner = LockOwner::this_process();
  owner.host = "node-7";
  owner.boot = "00000000-0000-0000-0000-000000000000";
  return owner;
}

// A number that was a process's and is none's now.
LockOwner of_a_dead_process() {
  auto owner = LockOwner::this_process();
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  owner.process = child;
  ++owner.started;
  return owner;
}

const LockOptions with_flock{};
const LockOptions without_flock{.use_flock = false};
// Whoever is not seen to be alive counts as silent for too long.
const LockOptions impatient{.silence_max = -1h, .use_flock = false};

TEST_F(Lock, IsOnesUntilItIsGivenUpWithOrWithoutFlock) {
  for (const auto& options : {with_flock, without_flock}) {
    {
      const auto lock = FolderLock::take(folder(), options);
      ASSERT_TRUE(lock) << lock.error().where;
      expect_refused(options, LockOwner::this_process());
      EXPECT_TRUE(check_held(lock.value().file()));
    }
    EXPECT_TRUE(fs::is_empty(folder()));
  }
}

TEST_F(Lock, OfALiveProcessIsNotTakenHoweverSilentItIs) {
  const auto lock = FolderLock::take(folder(), without_flock);
  ASSERT_TRUE(lock);
  expect_refused(impatient, LockOwner::this_process());
  EXPECT_TRUE(check_held(lock.value().file()));
}

TEST_F(Lock, OfADeadProcessIsTakenAtOnceWithOrWithoutFlock) {
  for (const auto& options : {with_flock, without_flock}) {
    leave_lock_of(of_a_dead_process());
    const auto lock = FolderLock::take(folder(), options);
    ASSERT_TRUE(lock) << lock.error().where;
    expect_refused(options, LockOwner::this_process());
  }
}

// As after kill -9 and a restart of a container: the number is in use again.
TEST_F(Lock, OfADeadProcessWhoseNumberAnotherHasIsTakenAtOnce) {
  auto owner = LockOwner::this_process();
  --owner.started;
  leave_lock_of(owner);
  EXPECT_TRUE(FolderLock::take(folder(), without_flock));
}

TEST_F(Lock, OfAnotherHostIsKeptWhileItIsHeardOfAndTakenWhenItIsNot) {
  leave_lock_of(of_another_host());
  expect_refused(with_flock, of_another_host());
  expect_refused(without_flock, of_another_host());
  EXPECT_TRUE(FolderLock::take(folder(), impatient));
}

TEST_F(Lock, IsKeptByItsHeartbeat) {
  const auto lock = FolderLock::take(folder(), {.heartbeat = 1ms});
  ASSERT_TRUE(lock);
  const auto changed = [&] {
    struct stat status {};
    EXPECT_EQ(::stat(owner_file().c_str(), &status), 0);
    return std::pair(status.st_ctim.tv_sec, status.st_ctim.tv_nsec);
  };
  const auto first = changed();
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (changed() == first && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_NE(changed(), first);
}

TEST_F(Lock, ThatIsLostIsToldAndItsNewOwnersIsLeftAlone) {
  const auto file = [&] {
    const auto lock = FolderLock::take(folder());
    EXPECT_TRUE(lock);
    const auto taken = lock_folder(folder()) / of_another_host().name();
    fs::rename(owner_file(), taken);
    for (const Status& held : {check_held(lock.value().file()), lock.value().check(), lock.value().heard()}) {
      EXPECT_EQ(held.error().code, Errc::io);
      EXPECT_EQ(
          held.error().where,
          folder().string() +
              ": this process was silent for so long that another process has taken the lock of the folder: process " +
              std::to_string(::getpid()) + " on node-7");
    }
    return taken;
  }();
  EXPECT_TRUE(fs::exists(file));
}

TEST_F(Lock, ThatIsLostIsToldOnceAndForEver) {
  std::vector<std::string> told;
  LockOptions options{.heartbeat = 1h, .use_flock = false};
  options.lost = [&](const Error& why) { told.push_back(why.where); };
  const auto lock = FolderLock::take(folder(), options);
  ASSERT_TRUE(lock && lock.value().check() && told.empty());
  const auto mine = owner_file(), taken = lock_folder(folder()) / of_another_host().name();
  fs::rename(mine, taken);
  EXPECT_FALSE(lock.value().check());
  fs::rename(taken, mine);  // also if the other gives it back
  EXPECT_FALSE(lock.value().check());
  EXPECT_FALSE(lock.value().heard());
  EXPECT_EQ(told.size(), 1u);
}

TEST_F(Lock, ThatIsLostIsNoticedByItsHeartbeat) {
  std::atomic<bool> told = false;
  LockOptions options{.heartbeat = 1ms};
  options.lost = [&](const Error&) { told = true; };
  const auto lock = FolderLock::take(folder(), options);
  ASSERT_TRUE(lock);
  fs::rename(owner_file(), lock_folder(folder()) / of_another_host().name());
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (!told && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_TRUE(told);
}

TEST_F(Lock, SaysWhatBecameOfIt) {
  {
    const auto lock = FolderLock::take(folder(), without_flock);
    fs::remove_all(lock_folder(folder()));
    EXPECT_EQ(lock.value().check().error().where, folder().string() + ": its lock was removed while it was in use");
  }
  const auto moved = folder().parent_path() / (folder().filename().string() + "-moved");
  const auto lock = FolderLock::take(folder(), without_flock);
  fs::rename(folder(), moved);
  EXPECT_EQ(lock.value().check().error().where,
            folder().string() + ": the folder was removed or renamed while it was in use");
  fs::rename(moved, folder());
}

// As after a suspension in which nobody else wanted the lock: by what only its owner can do.
TEST_F(Lock, OfAnOwnerThatWasSilentIsRenewedUnlessAnotherHasIt) {
  const LockOptions always_silent{.heartbeat = 1h, .silence_max = -1h, .use_flock = false};
  const auto lock = FolderLock::take(folder(), always_silent);
  ASSERT_TRUE(lock);
  const auto mine = owner_file();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(lock.value().check());
  EXPECT_EQ(owner_file(), mine);
  EXPECT_TRUE(check_held(lock.value().file()));
  // In the middle of it the file has another name for a moment.
  fs::rename(mine, mine.string() + "+");
  EXPECT_TRUE(check_held(lock.value().file()));
  fs::rename(mine.string() + "+", lock_folder(folder()) / of_another_host().name());
  EXPECT_FALSE(lock.value().check());
}

TEST_F(Lock, IsWaitedForAsLongAsTheOtherWants) {
  leave_lock_of(of_another_host());
  int asked = 0;
  LockOptions options{.use_flock = false};
  options.locked = [&](const Error& why) {
    EXPECT_NE(why.where.find("on node-7"), std::string::npos);
    return ++asked < 3;
  };
  EXPECT_FALSE(FolderLock::take(folder(), options));
  EXPECT_EQ(asked, 3);
  options.locked = [&](const Error&) { return fs::remove_all(lock_folder(folder())) > 0; };
  EXPECT_TRUE(FolderLock::take(folder(), options));
}

TEST_F(Lock, ThatIsAbandonedIsTakenByOneOfManyAtATime) {
  constexpr int takers = 8;
  for (int round = 0; round < 20; ++round) {
    leave_lock_of(round % 2 == 0 ? of_a_dead_process() : of_another_host());
    std::barrier start(takers);
    std::barrier tried(takers);
    std::atomic<int> held = 0;
    {
      std::vector<std::jthread> threads;
      for (int i = 0; i < takers; ++i)
        threads.emplace_back([&] {
          start.arrive_and_wait();
          const auto lock = FolderLock::take(folder(), impatient);
          if (lock) ++held;
          tried.arrive_and_wait();  // nobody gives it up before
        });
    }
    EXPECT_EQ(held, 1) << "round " << round;
    EXPECT_TRUE(fs::is_empty(folder()));
  }
}

TEST_F(Lock, OfAProcessThatWasKilledIsTakenAtOnce) {
  int pipe_ends[2];
  ASSERT_EQ(::pipe(pipe_ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const auto lock = FolderLock::take(folder());
    const char answer = lock ? '1' : '0';
    if (::write(pipe_ends[1], &answer, 1) != 1) ::_exit(1);
    ::pause();
    ::_exit(0);
  }
  char answer = 0;
  ASSERT_EQ(::read(pipe_ends[0], &answer, 1), 1);
  EXPECT_EQ(answer, '1');
  auto owner = LockOwner::this_process();
  owner.process = child;
  expect_refused(with_flock, owner);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(FolderLock::take(folder()));
  ::close(pipe_ends[0]);
  ::close(pipe_ends[1]);
}

TEST_F(Lock, OfAFolderThatIsNotThereIsAnErrorOfTheSystem) {
  EXPECT_EQ(FolderLock::take(folder() / "no").error().code, Errc::io);
}

TEST(LockOwner, IsReadFromItsName) {
  const auto owner = LockOwner::this_process();
  const auto read = LockOwner::from_name(owner.name());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->name(), owner.name());
  EXPECT_EQ(read->process, ::getpid());
  EXPECT_GT(read->started, 0u);
  EXPECT_TRUE(read->under_this_kernel() && read->may_be_alive());
  EXPECT_NE(LockOwner::this_process().token, owner.token);
  for (const char* name : {"", "a,b,c", "a,b,c,x,1,t", "a,b,c,1,,t", "a,b,c,1,2,t,u"})
    EXPECT_FALSE(LockOwner::from_name(name)) << name;
}

}  // namespace
}  // namespace tessera

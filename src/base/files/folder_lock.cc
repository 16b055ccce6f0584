#include "src/base/files/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <ctime>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/lock_owner.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/there.h"

namespace tessera {

namespace fs = std::filesystem;
using std::chrono::nanoseconds;

namespace {

nanoseconds last_change(const struct stat& status) {
  return std::chrono::seconds(status.st_ctim.tv_sec) + nanoseconds(status.st_ctim.tv_nsec);
}

// The file is opened first, because then network file systems ask their server and not their cache. Nothing when the
// file is gone.
std::optional<nanoseconds> last_change(const fs::path& path) {
  const FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) return std::nullopt;
  return last_change(status);
}

// The name of the file in the lock folder. Empty when there is none.
Result<std::string> owner_name(const fs::path& lock) {
  FolderReader reader(lock);
  if (const char* name = reader.next()) return std::string(name);
  const auto failed = reader.error();
  if (failed && failed != std::errc::no_such_file_or_directory) return io_error(lock, "cannot be read", failed.value());
  return std::string();
}

std::string words_for(const std::string& owner_name) {
  const auto owner = LockOwner::from_name(owner_name);
  return owner ? ": process " + std::to_string(owner->process) + " on " + owner->host : "";
}

Error locked(const fs::path& out, const std::string& name) {
  return error(Errc::usage, out.string() + ": another tessera is at work in it" + words_for(name));
}

// A clock that runs on while the machine is suspended.
nanoseconds boot_time() {
  timespec now{};
  ::clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + nanoseconds(now.tv_nsec);
}

// The name of the owner's file while the owner renames it and back.
std::string name_for_a_moment(std::string name) { return std::move(name) + "+"; }

// Whether the file is in its folder. The folder is listed, because a single name would be looked up in this machine's
// cache, which is old after a suspension.
Result<bool> is_listed(const fs::path& file) {
  const std::string name = file.filename().string(), for_a_moment = name_for_a_moment(name);
  FolderReader reader(file.parent_path());
  while (const char* entry = reader.next())
    if (entry == name || entry == for_a_moment) return true;
  const auto failed = reader.error();
  if (failed && failed != std::errc::no_such_file_or_directory && failed != std::errc::not_a_directory)
    return io_error(file.parent_path(), "cannot be read", failed.value());
  return false;
}

// Says why the lock no longer belongs to its owner.
Error lost_lock(const fs::path& out, const fs::path& lock) {
  const auto name = owner_name(lock);
  if (name && !name.value().empty()) {
    return error(Errc::io,
                 out.string() +
                     ": this process was silent for so long that another process has taken the lock of the folder" +
                     words_for(name.value()));
  }
  FolderReader reader(out);
  reader.next();
  if (reader.error() == std::errc::no_such_file_or_directory)
    return error(Errc::io, out.string() + ": the folder was removed or renamed while it was in use");
  return error(Errc::io, out.string() + ": its lock was removed while it was in use");
}

enum class Flock { held, refused, unknown };

Flock try_flock(const FileHandle& folder, bool use_flock) {
  if (!use_flock) return Flock::unknown;
  while (::flock(folder.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return Flock::refused;
    if (errno != EINTR) return Flock::unknown;
  }
  return Flock::held;
}

}  // namespace

struct FolderLock::Impl {
  fs::path out, lock;
  FileHandle folder;  // flock() holds it, where flock() works
  LockOwner owner;
  fs::path file;
  LockOptions options;
  nanoseconds patience{};              // how long an owner trusts its lock while silent; less than silence_max
  std::atomic<nanoseconds> touched{};  // the boot_time() just before the last successful touch
  std::mutex losing;
  std::atomic<bool> is_lost = false;
  Error why = {};  // guarded by `losing`
  std::mutex mutex;
  std::condition_variable_any woken;
  std::jthread thread;  // the last member, so that it ends before what it uses

  ~Impl() {
    if (thread.joinable()) {
      thread.request_stop();
      thread.join();
    }
    if (file.empty()) return;
    ::unlink(file.c_str());
    ::rmdir(lock.c_str());  // fails when another process has taken the folder meanwhile
  }

  void beat(const std::stop_token& stop) {
    std::unique_lock guard(mutex);
    while (!woken.wait_for(guard, stop, options.heartbeat, [&] { return stop.stop_requested(); })) {
      // Errors pass, as when a server does not answer for a while. When that lasts, check() finds the lock lost.
      if (check()) touch();
      if (is_lost) return;
    }
  }

  void touch() {
    const auto before = boot_time();
    if (::utimensat(AT_FDCWD, file.c_str(), nullptr, 0) == 0) touched = before;
  }

  bool was_heard() const { return boot_time() - touched.load() <= patience; }

  Status check() {
    if (!is_lost && was_heard()) {
      BOOST_OUTCOME_TRY(listed, is_listed(file));
      if (listed) return success();
    }
    {
      const std::lock_guard guard(losing);
      if (is_lost) return why;
      if (was_heard()) {  // another thread may have renewed the lock meanwhile
        BOOST_OUTCOME_TRY(listed, is_listed(file));
        if (listed) return success();
        why = lost_lock(out, lock);
      } else {
        const Status renewed = renew();
        if (renewed) return success();
        why = renewed.error();
      }
      is_lost = true;
    }
    if (options.lost) options.lost(why);
    return why;
  }

  // Renews the lock after a long silence, by a renaming that only one of all interested processes can do. REQUIRES:
  // `losing` is held.
  Status renew() {
    const auto before = boot_time();
    const fs::path moment = lock / name_for_a_moment(owner.name());
    if (std::rename(file.c_str(), moment.c_str()) != 0 || std::rename(moment.c_str(), file.c_str()) != 0) {
      const int reason = errno;
      if (reason == ENOENT || reason == ENOTDIR) return lost_lock(out, lock);
      const auto silence = std::chrono::duration_cast<std::chrono::seconds>(before - touched.load());
      return io_error(lock,
                      "cannot be reached after this process was silent for " + std::to_string(silence.count()) +
                          " s, in which another process may have taken the lock",
                      reason);
    }
    touched = before;
    return success();
  }

  // Removes what dead processes were making when they were killed.
  void remove_remains() const {
    const std::string prefix = new_lock_folder("", "").string();
    FolderReader reader(out);
    while (const char* entry = reader.next()) {
      const std::string name = entry;
      if (!name.starts_with(prefix)) continue;
      const auto maker = LockOwner::from_name(name.substr(prefix.size()));
      // The next owner tries again what cannot be removed now.
      if (maker && maker->under_this_kernel() && !maker->may_be_alive()) remove_tree(out / name);
    }
  }

  // Makes a new lock folder, which has its owner from the start. Returns false when there is a lock already.
  Result<bool> make(nanoseconds& now) {
    BOOST_OUTCOME_TRY(made, TemporaryFolder::make(new_lock_folder(out, owner.name())));
    const auto path = made.path() / owner.name();
    touched = boot_time();
    BOOST_OUTCOME_TRY(created, open_handle(path, O_WRONLY | O_CREAT | O_EXCL));
    struct stat status {};
    if (::fstat(created.get(), &status) != 0) return io_error(path, "cannot be examined", errno);
    now = last_change(status);
    if (std::rename(made.path().c_str(), lock.c_str()) == 0) {
      made.keep();
      return true;
    }
    if (errno == EEXIST || errno == ENOTEMPTY) return false;
    // A network file system may have renamed the folder and lost its answer.
    const int reason = errno;
    if (const auto there = is_there(file); there && there.value()) return true;
    return io_error(lock, "cannot be made", reason);
  }

  Status take() {
    BOOST_OUTCOME_TRY(opened, open_handle(out, O_RDONLY | O_DIRECTORY));
    folder = std::move(opened);
    const Flock flock = try_flock(folder, options.use_flock);
    if (flock == Flock::refused) {
      BOOST_OUTCOME_TRY(name, owner_name(lock));
      return locked(out, name);
    }
    // In each turn that ends without an answer another process has taken or given up the lock.
    constexpr int turns_max = 100;
    for (int turn = 0; turn < turns_max; ++turn) {
      nanoseconds now{};
      BOOST_OUTCOME_TRY(made, make(now));
      if (made) return success();
      BOOST_OUTCOME_TRY(name, owner_name(lock));
      const auto held = lock / name;
      const auto changed = last_change(held);
      if (name.empty() || !changed) continue;
      const auto other = LockOwner::from_name(name);
      const bool here = other && other->under_this_kernel();
      const bool dead = here && (flock == Flock::held || !other->may_be_alive());
      const bool answers = here && other->may_be_alive() && other->pid_namespace == owner.pid_namespace;
      const bool silent = !answers && now - *changed > options.silence_max;
      if (!dead && !silent) return locked(out, name);
      touched = boot_time();
      if (std::rename(held.c_str(), file.c_str()) == 0) return success();
      const int reason = errno;
      if (const auto there = is_there(file); there && there.value()) return success();
      if (reason != ENOENT) return io_error(lock, "cannot be taken over", reason);
    }
    return error(Errc::usage, out.string() + ": other processes lock it again and again");
  }
};

FolderLock::FolderLock(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FolderLock::FolderLock(FolderLock&&) noexcept = default;
FolderLock& FolderLock::operator=(FolderLock&&) noexcept = default;
FolderLock::~FolderLock() = default;

Result<FolderLock> FolderLock::take(const fs::path& out, const LockOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->out = out;
  impl->owner = LockOwner::this_process();
  impl->options = options;
  impl->patience = options.silence_max * 3 / 4;
  impl->lock = lock_folder(out);
  impl->file = impl->lock / impl->owner.name();
  while (true) {
    const Status taken = impl->take();
    if (taken) break;
    const bool another_has_it = taken.error().code == Errc::usage;
    if (!another_has_it || !options.locked || !options.locked(taken.error())) return taken.error();
  }
  impl->remove_remains();
  impl->thread = std::jthread([held = impl.get()](const std::stop_token& stop) { held->beat(stop); });
  return FolderLock(std::move(impl));
}

const fs::path& FolderLock::file() const { return impl_->file; }

Status FolderLock::check() const { return impl_->check(); }

Status FolderLock::heard() const { return !impl_->is_lost && impl_->was_heard() ? success() : impl_->check(); }

Status check_held(const fs::path& file) {
  if (file.empty()) return success();
  const auto listed = is_listed(file);
  if (!listed || listed.value()) return success();
  return lost_lock(file.parent_path().parent_path(), file.parent_path());
}

}  // namespace tessera

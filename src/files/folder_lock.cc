#include "src/files/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "src/files/descriptor.h"
#include "src/files/folder.h"
#include "src/files/lock_owner.h"
#include "src/files/names.h"
#include "src/files/temporary.h"
#include "src/files/there.h"

namespace tessera {

namespace fs = std::filesystem;
using std::chrono::nanoseconds;

namespace {

nanoseconds last_change(const struct stat& status) {
  return std::chrono::seconds(status.st_ctim.tv_sec) + nanoseconds(status.st_ctim.tv_nsec);
}

// Opened first: network file systems ask their server then, and not their cache. Nothing when the file is gone.
std::optional<nanoseconds> last_change(const fs::path& path) {
  const FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) return std::nullopt;
  return last_change(status);
}

// The file in the lock folder. Empty when there is none.
Result<std::string> owner_name(const fs::path& lock) {
  FolderReader reader(lock);
  if (const char* name = reader.next()) return std::string(name);
  const auto failed = reader.error();
  if (failed && failed != std::errc::no_such_file_or_directory) return io_error(lock, "cannot be read", failed.value());
  return std::string();
}

Error locked(const fs::path& out, const std::string& name) {
  const auto owner = LockOwner::from_name(name);
  std::string sentence = out.string() + ": another tessera is at work in it";
  if (owner) sentence += ": process " + std::to_string(owner->process) + " on " + owner->host;
  return error(Errc::usage, std::move(sentence));
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
  FileHandle folder;  // with flock(), where it works
  LockOwner owner;
  fs::path file;
  std::chrono::milliseconds heartbeat{};
  std::mutex mutex;
  std::condition_variable_any woken;
  std::jthread thread;  // last: ends before what it uses

  ~Impl() {
    if (thread.joinable()) {
      thread.request_stop();
      thread.join();
    }
    if (file.empty()) return;
    ::unlink(file.c_str());
    ::rmdir(lock.c_str());  // unless another has made it its own meanwhile
  }

  void beat(const std::stop_token& stop) {
    std::unique_lock guard(mutex);
    while (!woken.wait_for(guard, stop, heartbeat, [&] { return stop.stop_requested(); })) {
      // Errors pass: a server that does not answer for a while. Whether the lock is lost, check_held() finds out.
      ::utimensat(AT_FDCWD, file.c_str(), nullptr, 0);
    }
  }

  // What processes that are dead were making when they were killed.
  void remove_remains() const {
    const std::string prefix = new_lock_folder("", "").string();
    FolderReader reader(out);
    while (const char* entry = reader.next()) {
      const std::string name = entry;
      if (!name.starts_with(prefix)) continue;
      const auto maker = LockOwner::from_name(name.substr(prefix.size()));
      // What cannot be removed the next owner tries again.
      if (maker && maker->under_this_kernel() && !maker->may_be_alive()) remove_tree(out / name);
    }
  }

  // A new lock folder, with its owner in it from the start. False when there is one.
  Result<bool> make(nanoseconds& now) {
    BOOST_OUTCOME_TRY(made, TemporaryFolder::make(new_lock_folder(out, owner.name())));
    const auto path = made.path() / owner.name();
    BOOST_OUTCOME_TRY(created, open_handle(path, O_WRONLY | O_CREAT | O_EXCL));
    struct stat status {};
    if (::fstat(created.get(), &status) != 0) return io_error(path, "cannot be examined", errno);
    now = last_change(status);
    if (std::rename(made.path().c_str(), lock.c_str()) == 0) {
      made.keep();
      return true;
    }
    if (errno == EEXIST || errno == ENOTEMPTY) return false;
    // A network file system may have done it and lost its answer.
    const int reason = errno;
    if (const auto there = is_there(file); there && there.value()) return true;
    return io_error(lock, "cannot be made", reason);
  }

  Status take(const LockOptions& options) {
    BOOST_OUTCOME_TRY(opened, open_handle(out, O_RDONLY | O_DIRECTORY));
    folder = std::move(opened);
    const Flock flock = try_flock(folder, options.use_flock);
    if (flock == Flock::refused) {
      BOOST_OUTCOME_TRY(name, owner_name(lock));
      return locked(out, name);
    }
    // Each turn that ends without an answer, somebody else has taken or given up the lock.
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
  impl->heartbeat = options.heartbeat;
  impl->lock = lock_folder(out);
  impl->file = impl->lock / impl->owner.name();
  BOOST_OUTCOME_TRYV(impl->take(options));
  impl->remove_remains();
  impl->thread = std::jthread([held = impl.get()](const std::stop_token& stop) { held->beat(stop); });
  return FolderLock(std::move(impl));
}

const fs::path& FolderLock::file() const { return impl_->file; }

Status check_held(const fs::path& file) {
  // Opened, as in last_change(). Other errors pass, as in beat().
  if (file.empty() || FileHandle(::open(file.c_str(), O_RDONLY | O_CLOEXEC)).get() >= 0 || errno != ENOENT)
    return success();
  return error(Errc::io, file.parent_path().parent_path().string() +
                             ": was silent for so long that another process has taken its lock");
}

}  // namespace tessera

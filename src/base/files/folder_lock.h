// A lock that keeps two processes from working in one folder, also from two machines over a network file system.
//
// The lock is a folder, lock_folder(out), with one file. The file's name is the owner: host, boot, process and a random
// token.
//   made        A new folder with the file in it is renamed to lock_folder(out). Renaming fails when that folder exists
//               and is not empty.
//   held        The owner touches the file every few seconds, after checking that the file is still there.
//   taken over  The file is renamed to the new owner's name. The old name has the old token. So of several processes
//               that find the same lock abandoned one succeeds, however late the others are. Renaming, like touching,
//               renews the time of the file's last change (ctime), by which silence is measured.
//   given up    The file is removed, then the folder.
//
// A lock is abandoned when its owner ran under this kernel and is dead, or ran elsewhere and has been silent for a
// minute. flock() of `out` tells at once of owners under this kernel. Where flock() does not work (some network file
// systems), processes are looked up.
//
// A lock is lost when its owner stood still for long (stopped, suspended, cut off from the disk) and finds its file
// renamed or gone. The folder then belongs to another process. check() reports that, and `lost` may end the process. An
// owner that was silent for three quarters of `silence_max` does not trust its lock before it has renamed its own file
// and back. Only one of all processes that try can rename the file. So either the lock is still the owner's, or the
// owner learns that it is not.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>

#include "src/base/result.h"

namespace tessera {

struct LockOptions {
  std::chrono::milliseconds heartbeat{5'000};
  std::chrono::milliseconds silence_max{60'000};
  bool use_flock = true;  // false: behave as where flock() does not work
  // Called once, with the reason, by the first thread that finds the lock lost.
  std::function<void(const Error&)> lost = {};
  // Called with a sentence that names the owner while another process has the lock. Return true to try again.
  std::function<bool(const Error&)> locked = {};
};

// Checks a lock by its file: error io when the lock is another process's, or gone. What is in the folder is then no
// longer this job's. To be called before each write. The check lists the lock folder, because network file systems look
// up names in a cache. Errors of the system are no answer and count as success, and so does an empty path.
Status check_held(const std::filesystem::path& file);

// A held lock, given up by the destructor.
class FolderLock {
 public:
  // Locks `out`, which must exist. Errors: usage, naming the owner, when another process has the lock; io.
  static Result<FolderLock> take(const std::filesystem::path& out, const LockOptions& options = {});
  FolderLock(FolderLock&&) noexcept;
  FolderLock& operator=(FolderLock&&) noexcept;
  ~FolderLock();

  // The file of this owner in the lock folder.
  const std::filesystem::path& file() const;
  // Error io when the lock is lost, now and ever after, and when the file system does not say who has the lock. To be
  // called before each write that other processes could see. Thread-safe.
  Status check() const;
  // Like check(), but looks at the folder only when the owner was silent for so long that another process may have the
  // lock.
  Status heard() const;

 private:
  struct Impl;
  explicit FolderLock(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera

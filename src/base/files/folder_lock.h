// Keeps two processes from working in one folder, also from two machines over a network file system.
//
// The lock is a folder, lock_folder(out), with one file whose name is its owner: host, boot, process and a random
// token.
//   made        a new folder with the file in it is renamed to lock_folder(out), which fails when there is one that is
//               not empty
//   held        its owner touches the file every few seconds, after a look that the file is still there
//   taken over  the file is renamed to the new owner's name. The old name holds the old token, so of several that found
//               the same lock abandoned one succeeds, however late the others are; and renaming, like touching, renews
//               the time of the file's last change (ctime), by which silence is measured
//   given up    the file is removed, then the folder
//
// Abandoned: the owner ran under this kernel and is dead, or ran elsewhere and has been silent for a minute. flock() of
// `out` tells of owners under this kernel at once. Where it does not work (some network file systems), processes are
// looked up.
//
// Lost: an owner that stood still for long (stopped, suspended, cut off from the disk) may find its file renamed or
// gone. By then the folder is another's, so check() tells, and `lost` may end the process. An owner that was silent for
// three quarters of the time after which others may take the lock believes nothing before it has renamed its own file
// and back, which works for one of all who try: either the lock is its own still, or the owner knows that it is not.
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
  bool use_flock = true;  // false: as where there is none
  // Called once, with the reason, by the first thread that finds the lock lost.
  std::function<void(const Error&)> lost = {};
  // Called with a sentence that names the owner while another has the lock. True: it is tried again.
  std::function<bool(const Error&)> locked = {};
};

// Error io once the lock whose file this was is another process's, or is gone: what is in the folder is not ours any
// more. To be asked before each write. The lock folder is listed, since network file systems look names up in their own
// memory. Errors of the system are no answer, and pass. No file: nothing is locked.
Status check_held(const std::filesystem::path& file);

class FolderLock {
 public:
  // `out` exists. Error usage, naming the owner, when it is locked; io.
  static Result<FolderLock> take(const std::filesystem::path& out, const LockOptions& options = {});
  FolderLock(FolderLock&&) noexcept;
  FolderLock& operator=(FolderLock&&) noexcept;
  ~FolderLock();

  // Of this owner, in the lock folder.
  const std::filesystem::path& file() const;
  // Error io when the lock is lost, now and from then on; also when the file system does not say who has it. To be
  // asked before each write that others could see. Safe from any thread.
  Status check() const;
  // The same without a look at the folder, unless the owner was silent for so long that others may have the lock.
  Status heard() const;

 private:
  struct Impl;
  explicit FolderLock(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera

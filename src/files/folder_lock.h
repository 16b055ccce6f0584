// Keeps two processes from working in one folder, also from two machines over a network file system.
//
// The lock is a folder, lock_folder(out), with one file whose name is its owner: host, boot, process and a random
// token.
//   made        a new folder with the file in it is renamed to lock_folder(out), which fails when there is one that is
//               not empty
//   held        its owner touches the file every few seconds
//   taken over  the file is renamed to the new owner's name. The old name holds the old token, so of several that found
//               the same lock abandoned one succeeds, however late the others are; and renaming, like touching, renews
//               the time of the file's last change (ctime), by which silence is measured
//   given up    the file is removed, then the folder
//
// Abandoned: the owner ran under this kernel and is dead, or ran elsewhere and has been silent for a minute. flock() of
// `out` tells of owners under this kernel at once. Where it does not work (some network file systems), processes are
// looked up.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>

#include "src/base/result.h"

namespace tessera {

struct LockOptions {
  std::chrono::milliseconds heartbeat{5'000};
  std::chrono::milliseconds silence_max{60'000};
  bool use_flock = true;  // false: as where there is none
};

// Error io once the lock whose file this was is another process's, because its owner was silent too long (suspended,
// cut off): what is in the folder is the other's. To be asked before each write. No file: nothing is locked.
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

 private:
  struct Impl;
  explicit FolderLock(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera

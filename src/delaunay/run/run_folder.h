// The run folder of a job over a result, beside what the job writes. It is removed when the outcome is complete. If the
// job fails and can be resumed, the folder stays with its content.
#pragma once

#include <filesystem>
#include <memory>
#include <utility>

#include "src/base/files/folder_lock.h"
#include "src/base/result.h"

namespace tessera {

class RunFolder {
 public:
  // Makes the folder if there is none, and locks it. Without `resume`, removes what an earlier process has left there.
  // `what` is made there, for errors: "the surface". Errors: io; usage when another process works there, or when there
  // is something else at the path.
  static Result<RunFolder> claim(std::filesystem::path path, const char* what, bool resume,
                                 const LockOptions& lock = {});
  RunFolder(RunFolder&&) noexcept = default;
  RunFolder& operator=(RunFolder&&) = delete;
  ~RunFolder();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path lock_file() const { return lock_->file(); }
  // The outcome is complete.
  void done() { done_ = true; }

 private:
  RunFolder(std::filesystem::path path, FolderLock lock, bool resume)
      : path_(std::move(path)), lock_(std::make_unique<FolderLock>(std::move(lock))), resume_(resume) {}

  std::filesystem::path path_;
  std::unique_ptr<FolderLock> lock_;  // null: moved from
  bool resume_;
  bool done_ = false;
};

}  // namespace tessera

// Which job may write into a result folder, and which of its content may be deleted.
//
//   state      | what is there                         | triangulate may write
//   absent     | nothing, its parent exists            | always
//   empty      | an empty folder, or a crashed routing | always
//   unfinished | .run/plan.json                        | with --resume or --overwrite
//   broken     | what else a run may have left at any moment
//              |                                       | with --resume or --overwrite, which start again
//   finished   | a manifest                            | with --overwrite; --resume has nothing to write
//   foreign    | anything else                         | never
//
// A run is routed into a folder of this process and renamed to .run when it is complete. An old result is removed just
// before that. So errors of the new input are found while the old result is still there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

#include "src/base/files/folder_lock.h"
#include "src/base/files/names.h"
#include "src/base/result.h"

namespace tessera {

enum class FolderState : std::uint8_t { absent, empty, unfinished, broken, finished };

// The output folder of one job, from its inspection to its end. Not thread-safe.
class ResultFolder {
 public:
  // Inspects the folder, and creates nothing. Error io when `out` is not a folder or cannot be inspected; usage when
  // its state forbids the job.
  static Result<ResultFolder> inspect(std::filesystem::path out, bool resume, bool overwrite);
  ResultFolder(ResultFolder&&) noexcept = default;
  ResultFolder& operator=(ResultFolder&&) = delete;

  const std::filesystem::path& path() const { return out_; }
  FolderState state() const { return state_; }
  // Whether the job continues the run that is there, or finds it finished.
  bool resuming() const { return resuming_; }
  std::filesystem::path run() const { return run_folder(out_); }
  std::filesystem::path new_run() const { return new_run_folder(out_); }

  // Whether the folder has a run that is routed.
  Result<bool> has_run() const;

  // Sets how claim() locks the folder; the default is the one of all programs.
  void lock_with(LockOptions how) { how_to_lock_ = std::move(how); }
  // Creates the folder if it is absent, tests that it can be written, and locks it until destruction. Error usage when
  // another process works in it.
  Status claim();
  // Error io when another process has taken the lock meanwhile (folder_lock.h). Call this before replacing anything
  // that other processes can see.
  Status check_claim() const { return check_held(lock_file()); }
  // Returns the lock file of the claim; empty before it.
  std::filesystem::path lock_file() const { return lock_ ? lock_->file() : std::filesystem::path(); }
  // Removes what a crashed routing left, and an unfinished run that is to be overwritten, with the tiles that it has
  // stored.
  Status discard_runs();
  // Removes the old result, and renames the new run to .run.
  Status accept_new_run();
  // Removes the run folder: the result is complete, and abandon() leaves it alone.
  Status finish();
  // Removes everything that this job has made, and the folder if it was absent. Keeps an old result that is still
  // there, and a run that this job resumed. Never fails, as the caller has an error to report already.
  void abandon() noexcept;
  // To be called after an interruption. Returns true when the run can be resumed, or cannot be inspected; else does the
  // same as abandon() and returns false.
  bool abandon_unless_resumable();

 private:
  ResultFolder(std::filesystem::path out, FolderState state, bool resuming)
      : out_(std::move(out)), state_(state), resuming_(resuming) {}
  void remove_unfinished();
  Status remove_result() const;
  Status remove_run() const;

  std::filesystem::path out_;
  FolderState state_;
  bool resuming_;
  bool created_ = false;
  bool old_result_stands_ = false;
  bool complete_ = false;
  LockOptions how_to_lock_;
  std::optional<FolderLock> lock_;
};

}  // namespace tessera

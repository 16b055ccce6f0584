// Who may write into a result folder, and what of it is ours to delete.
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
// A run is routed into a folder of this process's own and renamed to .run when complete. An old result is removed just
// before that: whatever is wrong with the new input, it is found while the old result still stands.
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

class ResultFolder {
 public:
  // Creates nothing. Error io when `out` is not a folder or cannot be looked at; usage when its state forbids the job.
  static Result<ResultFolder> inspect(std::filesystem::path out, bool resume, bool overwrite);
  ResultFolder(ResultFolder&&) noexcept = default;
  ResultFolder& operator=(ResultFolder&&) = delete;

  const std::filesystem::path& path() const { return out_; }
  FolderState state() const { return state_; }
  // Whether the job continues the run that is there, or finds it finished.
  bool resuming() const { return resuming_; }
  std::filesystem::path run() const { return run_folder(out_); }
  std::filesystem::path new_run() const { return new_run_folder(out_); }

  // Whether there is a run that is routed.
  Result<bool> has_run() const;

  // How claim() locks; as all do by default.
  void lock_with(LockOptions how) { how_to_lock_ = std::move(how); }
  // Creates the folder if absent, tries that it can be written, and locks it until destruction. Error usage when
  // another process works in it.
  Status claim();
  // Error io when another process has taken the lock meanwhile (folder_lock.h). To be asked before what others can see
  // is replaced.
  Status check_claim() const { return check_held(lock_file()); }
  // Of the claim; none before it.
  std::filesystem::path lock_file() const { return lock_ ? lock_->file() : std::filesystem::path(); }
  // Removes what a crashed routing left, and an unfinished run that is to be overwritten, with the tiles it has stored.
  Status discard_runs();
  // Removes the old result and makes the new run the run.
  Status accept_new_run();
  // Removes the run folder: the result is complete, and abandon() leaves it alone.
  Status finish();
  // Removes everything this job has made; the folder too when it was absent. Keeps an old result that still stands, and
  // a run that this job resumed. Never fails: the error that led here is the one to tell.
  void abandon() noexcept;
  // After an interruption: true when the run can be resumed, or cannot be looked at; else as abandon().
  bool interrupted();

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

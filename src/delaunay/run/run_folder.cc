#include "src/delaunay/run/run_folder.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// Empties a locked folder. The lock stays to the end, as it marks the folder as a run folder. The plan goes first,
// so that no process continues from a part of the rest. What says that the outcome has its place goes last, so that no
// process makes the outcome again.
Status clear(const fs::path& path) {
  BOOST_OUTCOME_TRYV(remove_whole(plan_file(path)));
  BOOST_OUTCOME_TRY(names, sorted_names(path));
  for (const auto& name : names) {
    if (is_lock_name(name) || name == outcome_file(path).filename()) continue;
    BOOST_OUTCOME_TRYV(remove_whole(path / name));
  }
  return remove_whole(outcome_file(path));
}

}  // namespace

Result<RunFolder> RunFolder::claim(fs::path path, const char* what, bool resume, const LockOptions& lock_options) {
  BOOST_OUTCOME_TRY(there, is_there(path, FollowLinks::no));
  if (there) {
    BOOST_OUTCOME_TRY(folder, is_folder(path, FollowLinks::no));
    bool ours = folder;
    if (folder) {
      BOOST_OUTCOME_TRY(names, sorted_names(path));
      const std::string plan = plan_file(path).filename();
      ours = names.empty() || std::any_of(names.begin(), names.end(),
                                          [&](const std::string& name) { return name == plan || is_lock_name(name); });
    }
    if (!ours)
      return error(Errc::usage, path.string() + ": is in the way: " + what +
                                    " is made in a folder of this name; rename or remove it");
  }
  const fs::path parent = path.parent_path();
  if (!parent.empty()) {
    BOOST_OUTCOME_TRY(folder, is_folder(parent));
    if (!folder) return error(Errc::io, parent.string() + ": does not exist, or is not a folder");
  }
  BOOST_OUTCOME_TRYV(make_directories(path));
  BOOST_OUTCOME_TRY(lock, FolderLock::take(path, lock_options));
  BOOST_OUTCOME_TRY(begun, is_there(plan_file(path)));
  if (!resume || !begun) {
    BOOST_OUTCOME_TRYV(clear(path));
  }
  return RunFolder(std::move(path), std::move(lock), resume);
}

RunFolder::~RunFolder() {
  if (!lock_) return;
  const auto begun = is_there(plan_file(path_));
  const bool stays = resume_ && !done_ && begun && begun.value();
  // What cannot be removed now is removed when the job is run again.
  const bool cleared = !stays && lock_->check() && clear(path_);
  lock_.reset();
  std::error_code others;
  if (cleared) fs::remove(path_, others);  // stays when another process uses it by now
}

}  // namespace tessera

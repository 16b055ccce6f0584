#include "src/surface/run_folder.h"

#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/there.h"
#include "src/files/whole_file.h"

namespace tessera::surface {

namespace fs = std::filesystem;

Result<RunFolder> RunFolder::claim(fs::path path, bool resume, const LockOptions& lock_options) {
  BOOST_OUTCOME_TRY(there, is_there(path, FollowLinks::no));
  if (there) {
    BOOST_OUTCOME_TRY(folder, is_folder(path, FollowLinks::no));
    bool ours = folder;
    if (folder) {
      BOOST_OUTCOME_TRY(empty, is_empty_folder(path));
      BOOST_OUTCOME_TRY(plan, is_there(plan_file(path)));
      BOOST_OUTCOME_TRY(lock, is_there(lock_folder(path)));
      ours = empty || plan || lock;
    }
    if (!ours) return error(Errc::usage, path.string() + ": is in the way: surfaces are made in a folder of this name");
  }
  const fs::path parent = path.parent_path();
  if (!parent.empty()) {
    BOOST_OUTCOME_TRY(folder, is_folder(parent));
    if (!folder) return error(Errc::io, parent.string() + ": is not there, or no folder");
  }
  BOOST_OUTCOME_TRYV(make_directories(path));
  BOOST_OUTCOME_TRY(lock, FolderLock::take(path, lock_options));
  if (!resume) {
    const fs::path kept = lock_folder(path).filename();
    BOOST_OUTCOME_TRY(names, sorted_names(path));
    for (const auto& name : names) {
      if (name == kept.native()) continue;
      BOOST_OUTCOME_TRYV(remove_whole(path / name));
    }
  }
  return RunFolder(std::move(path), std::move(lock), resume);
}

RunFolder::~RunFolder() {
  if (!lock_) return;
  const bool ours = lock_->check().has_value();
  lock_.reset();
  const auto begun = is_there(plan_file(path_));
  const bool stays = resume_ && !done_ && begun && begun.value();
  if (ours && !stays) (void)remove_tree(path_);  // what stays goes when the surface is made anew
}

}  // namespace tessera::surface

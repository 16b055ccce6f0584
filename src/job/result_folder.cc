#include "src/job/result_folder.h"

#include <unistd.h>

#include <cerrno>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/result/store/tile_store.h"

namespace tessera {
namespace fs = std::filesystem;
namespace {

Result<bool> is_run(const fs::path& folder) { return is_regular(plan_file(folder)); }

template <class Ours>
Result<bool> holds_only(const fs::path& folder, Ours ours) {
  FolderReader reader(folder);
  while (const char* name = reader.next()) {
    if (!ours(name)) return false;
  }
  if (reader.error() == std::errc::not_a_directory) return false;
  if (reader.error()) return io_error(folder, "cannot be read", reader.error().value());
  return true;
}

// Other programs have folders named .run, too, so the content is checked.
Result<bool> is_part_of_run(const fs::path& entry) {
  if (is_new_run_name(entry)) return true;
  if (entry.filename() != run_folder("")) return false;
  return holds_only(entry, is_run_name);
}

Error refused_by_system(const fs::path& path, const std::string& reason) {
  return error(Errc::io, path.string() + ": " + reason);
}

}  // namespace

Result<ResultFolder> ResultFolder::inspect(fs::path out, bool resume, bool overwrite) {
  BOOST_OUTCOME_TRY(found, look_at(out));
  if (!found) {
    std::error_code ec;
    auto parent = fs::absolute(out, ec);
    if (ec) return refused_by_system(out, ec.message());
    if (!parent.has_filename()) parent = parent.parent_path();  // "out/"
    parent = parent.parent_path();
    BOOST_OUTCOME_TRY(place, is_folder(parent));
    if (!place) return refused_by_system(out, "the folder around it does not exist");
    return ResultFolder(std::move(out), FolderState::absent, false);
  }
  if (!S_ISDIR(found->st_mode)) return refused_by_system(out, "is not a folder");

  bool anything = false, part_of_run = false;
  FolderReader reader(out);
  while (const char* name = reader.next()) {
    anything = anything || (!is_new_run_name(name) && !is_lock_name(name));
    BOOST_OUTCOME_TRY(part, is_part_of_run(out / name));
    part_of_run = part_of_run || part;
  }
  if (reader.error()) return refused_by_system(out, "cannot be read: " + reader.error().message());
  BOOST_OUTCOME_TRY(manifest, is_there(manifest_file(out)));
  if (manifest) {
    // Tessera neither builds on a damaged or newer manifest, nor deletes it: its owner decides.
    const auto read = read_manifest(out);
    if (!read) return read.error();
    if (resume) return ResultFolder(std::move(out), FolderState::finished, true);
    if (!overwrite) {
      return error(Errc::usage,
                   out.string() + ": holds a finished result; " + option("overwrite", "true") + " replaces it");
    }
    return ResultFolder(std::move(out), FolderState::finished, false);
  }
  BOOST_OUTCOME_TRY(routed, is_run(run_folder(out)));
  if (routed) {
    if (!resume && !overwrite) {
      return error(Errc::usage, out.string() + ": holds an unfinished run; " + option("resume", "true") +
                                    " continues it, " + option("overwrite", "true") + " starts again");
    }
    return ResultFolder(std::move(out), FolderState::unfinished, resume);
  }
  if (anything && part_of_run) {
    if (!resume && !overwrite) {
      return error(Errc::usage, out.string() + ": holds the rest of a run that cannot be continued; " +
                                    option("overwrite", "true") + " starts again");
    }
    return ResultFolder(std::move(out), FolderState::broken, false);
  }
  if (anything) {
    return error(Errc::usage,
                 out.string() + ": is not empty, and does not hold a result of Tessera; choose another folder");
  }
  return ResultFolder(std::move(out), FolderState::empty, false);
}

Result<bool> ResultFolder::has_run() const { return is_run(run()); }

Status ResultFolder::claim() {
  std::error_code ec;
  if (state_ == FolderState::absent) {
    created_ = fs::create_directory(out_, ec);
    if (ec) return refused_by_system(out_, "cannot be made: " + ec.message());
  }
  if (access(out_.c_str(), W_OK | X_OK) != 0) return io_error(out_, "cannot be written", errno);
  BOOST_OUTCOME_TRY(lock, FolderLock::take(out_, how_to_lock_));
  lock_ = std::move(lock);
  old_result_stands_ = state_ == FolderState::finished;
  return success();
}

Status ResultFolder::discard_runs() {
  FolderReader reader(out_);
  while (const char* name = reader.next()) {
    if (!is_new_run_name(name)) continue;
    BOOST_OUTCOME_TRYV(remove_whole(out_ / name));
  }
  if (reader.error()) return refused_by_system(out_, "cannot be read: " + reader.error().message());
  if (resuming_) return success();
  return remove_run();
}

// At every moment, what is left is known to be Tessera's: a run without its plan is broken, and its folder is removed
// last.
Status ResultFolder::remove_run() const {
  BOOST_OUTCOME_TRYV(remove_file(plan_file(run())));
  if (!old_result_stands_ && !complete_) {
    BOOST_OUTCOME_TRYV(remove_result());
  }
  return remove_whole(run());
}

Status ResultFolder::remove_result() const {
  std::error_code ec;
  // The manifest is removed first: without it no program takes the rest for a result.
  fs::remove(manifest_file(out_), ec);
  if (ec) return refused_by_system(manifest_file(out_), "cannot be removed: " + ec.message());
  const auto remove_from = [&](const fs::path& folder, bool (*ours)(const fs::path&)) -> Status {
    BOOST_OUTCOME_TRY(there, is_folder(folder, FollowLinks::no));
    if (!there) return success();
    FolderReader reader(folder);
    while (const char* name = reader.next()) {
      const auto file = folder / name;
      if (!ours(file)) continue;
      BOOST_OUTCOME_TRY(below, is_folder(file, FollowLinks::no));
      if (below) continue;
      BOOST_OUTCOME_TRYV(remove_file(file));
    }
    if (reader.error()) return refused_by_system(folder, "cannot be cleared: " + reader.error().message());
    return success();
  };
  BOOST_OUTCOME_TRYV(remove_whole(versions_folder(out_)));
  BOOST_OUTCOME_TRYV(remove_from(out_, is_result_name));
  BOOST_OUTCOME_TRYV(remove_from(tiles_folder(out_), is_tile_name));
  fs::remove(tiles_folder(out_), ec);  // stays when it has files of other programs
  return success();
}

Status ResultFolder::accept_new_run() {
  BOOST_OUTCOME_TRYV(check_claim());
  BOOST_OUTCOME_TRYV(remove_result());
  old_result_stands_ = false;
  std::error_code ec;
  fs::rename(new_run(), run(), ec);
  if (ec) return refused_by_system(run(), "cannot be made: " + ec.message());
  return success();
}

Status ResultFolder::finish() {
  BOOST_OUTCOME_TRYV(check_claim());
  complete_ = true;
  return remove_run();
}

void ResultFolder::abandon() noexcept {
  try {
    remove_unfinished();
  } catch (const std::bad_alloc&) {  // see the header
  }
}

void ResultFolder::remove_unfinished() {
  std::error_code ignored;  // see the header
  // Without the lock another process may be at work.
  if (!lock_ && created_) fs::remove(out_, ignored);  // only when empty
  if (complete_ || !lock_ || !check_held(lock_->file())) return;
  remove_tree(new_run());
  if (resuming_) return;
  if (!old_result_stands_ && !remove_run()) return;
  if (!created_) return;
  lock_.reset();              // the lock is in the folder
  fs::remove(out_, ignored);  // only when empty
}

bool ResultFolder::abandon_unless_resumable() {
  // If that is unknown, the run stays.
  if (const auto run = has_run(); !run || run.value()) return true;
  abandon();
  return false;
}

}  // namespace tessera

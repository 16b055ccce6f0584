// Changes of result folders: making, replacing and removing, all through the staging folder.
#include <algorithm>
#include <set>
#include <utility>

#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/update_names.h"
#include "src/base/files/whole_file.h"
#include "src/base/random_token.h"
#include "src/service/naming.h"
#include "src/service/processes/kinds.h"
#include "src/service/results/owners.h"
#include "src/service/results/result_folders.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

// Removes our files from a result folder that has lost its name, and the folder when it is empty then.
Status remove_result(const fs::path& folder) {
  BOOST_OUTCOME_TRYV(remove_file(manifest_file(folder)));
  BOOST_OUTCOME_TRYV(remove_whole(exports_folder(folder)));
  BOOST_OUTCOME_TRYV(remove_whole(run_folder(folder)));
  BOOST_OUTCOME_TRYV(remove_whole(versions_folder(folder)));
  BOOST_OUTCOME_TRY(with_tiles, is_folder(tiles_folder(folder), FollowLinks::no));
  if (with_tiles) {
    BOOST_OUTCOME_TRY(tiles, sorted_names(tiles_folder(folder)));
    for (const auto& name : tiles) {
      if (!is_tile_name(name)) continue;
      BOOST_OUTCOME_TRYV(remove_file(tiles_folder(folder) / name));
    }
  }
  BOOST_OUTCOME_TRY(names, sorted_names(folder));
  for (const auto& name : names) {
    if (is_result_name(name)) {
      BOOST_OUTCOME_TRYV(remove_file(folder / name));
    } else if (is_lock_name(name) || is_new_run_name(name)) {
      BOOST_OUTCOME_TRYV(remove_whole(folder / name));
    }
  }
  std::error_code foreign;  // folders that still have files stay
  fs::remove(tiles_folder(folder), foreign);
  fs::remove(folder, foreign);
  return success();
}

// The job of an unfinished folder, also when a change is made there.
std::string job_of_run(const std::string& unfinished) {
  const std::string end = update_run_folder("x").string().substr(1);
  return unfinished.ends_with(end) ? unfinished.substr(0, unfinished.size() - end.size()) : unfinished;
}

}  // namespace

Status ResultFolders::open(const std::set<std::string>& jobs) {
  BOOST_OUTCOME_TRYV(make_directories(results_));
  // `remove` is called for entries with the name of a folder that is being removed.
  const auto clear = [&](const fs::path& folder, Status (*remove)(const fs::path&)) -> Status {
    BOOST_OUTCOME_TRY(names, sorted_names(folder));
    for (const auto& name : names) {
      const auto job = job_of_run(job_of_unfinished(name));
      if (token_of_removed(name)) {
        BOOST_OUTCOME_TRYV(remove(folder / name));
      } else if (JobIds::is_id(job) && !jobs.contains(job)) {
        BOOST_OUTCOME_TRYV(drop(folder / name));
      }
    }
    return success();
  };
  BOOST_OUTCOME_TRYV(clear(results_, remove_result));
  BOOST_OUTCOME_TRY(results, names());
  for (const auto& name : results) {
    BOOST_OUTCOME_TRY(with_exports, is_folder(exports_folder(folder(name)), FollowLinks::no));
    if (!with_exports) continue;
    BOOST_OUTCOME_TRYV(clear(exports_folder(folder(name)), remove_whole));
  }
  return success();
}

Result<bool> ResultFolders::is_published(const std::string& job, std::string_view name) {
  BOOST_OUTCOME_TRY(unpublished, is_there(unfinished(job), FollowLinks::no));
  if (unpublished) return false;
  return made_by(name, job);
}

Result<fs::path> ResultFolders::publish(const std::string& job, const std::string& name, bool overwrite) {
  const auto made = unfinished(job);
  BOOST_OUTCOME_TRY(published, is_published(job, name));
  if (published) return fs::path();  // published before a crash
  fs::path replaced;
  BOOST_OUTCOME_TRY(anything, is_there(folder(name), FollowLinks::no));
  if (anything) {
    BOOST_OUTCOME_TRY(result, exists(name));
    if (!overwrite || !result)
      return error(Errc::usage,
                   "output: there is a file or folder called '" + name + "' already, and it is not replaced");
    // Until the new result is in its place, a successor would put the old one back.
    BOOST_OUTCOME_TRY(picked_up, desk_.pick_up(folder(name)));
    replaced = std::move(picked_up);
  }
  if (const Status moved = desk_.move(made, folder(name)); !moved) {
    if (!replaced.empty()) static_cast<void>(desk_.put_down(replaced, folder(name)));  // else a successor does
    return moved.error();
  }
  BOOST_OUTCOME_TRYV(sync_folder(results_));
  if (replaced.empty()) return replaced;
  const fs::path gone = removed_folder(results_, random_token());
  BOOST_OUTCOME_TRYV(desk_.put_down(replaced, gone));
  return gone;
}

// Renames through the staging folder first, because another daemon may have a job with this id by now.
Status ResultFolders::drop(const fs::path& folder) {
  BOOST_OUTCOME_TRY(any, is_there(folder, FollowLinks::no));
  if (!any) return success();
  const fs::path gone = removed_folder(folder.parent_path(), random_token());
  BOOST_OUTCOME_TRYV(desk_.move(folder, gone));
  return remove_whole(gone);
}

Status ResultFolders::drop_unfinished(const std::string& job) {
  BOOST_OUTCOME_TRYV(drop_change(job));
  return drop(unfinished(job));
}
Status ResultFolders::drop_change(const std::string& job) { return drop(update_run_folder(unfinished(job))); }
Status ResultFolders::drop_unfinished_export(std::string_view exported_from, const std::string& job,
                                             const fs::path& but) {
  const auto folder = unfinished_export(exported_from, job);
  bool stays = false;
  if (!but.empty()) {
    BOOST_OUTCOME_TRY(there, is_there(folder / but, FollowLinks::no));
    stays = there;
  }
  if (!stays) return drop(folder);
  BOOST_OUTCOME_TRY(names, sorted_names(folder));
  for (const auto& name : names) {
    if (name == but.native()) continue;
    BOOST_OUTCOME_TRYV(remove_whole(folder / name));
  }
  return success();
}

Status ResultFolders::discard(const fs::path& folder) {
  if (folder.empty()) return success();
  return remove_result(folder);
}

Result<std::string> ResultFolders::export_owner(std::string_view name, const std::string& file) const {
  return owner_of(exports_folder(folder(name)) / file);
}

Status ResultFolders::publish_export(const proto::JobRecord& job) {
  const auto& name = job.triangulation();
  const auto output = export_output(job.inputs()).value_or("");
  const auto made = unfinished_export(name, job.id());
  const auto to = exports_folder(folder(name));
  std::set<std::string> replaceable{job.caller()};  // owners whose files may be replaced
  BOOST_OUTCOME_TRY(replaced, export_exists(name, output));
  if (replaced) {
    BOOST_OUTCOME_TRY(owner, export_owner(name, output));
    replaceable.insert(owner);
  }
  BOOST_OUTCOME_TRY(files, sorted_names(made));
  for (const auto& file : files) {
    BOOST_OUTCOME_TRY(stands, export_exists(name, file));
    if (file == output || !stands) continue;
    BOOST_OUTCOME_TRY(owner, export_owner(name, file));
    if (!replaceable.contains(owner))
      return error(Errc::usage,
                   "output: the job would also replace the export '" + file + "', which another caller has made");
  }
  BOOST_OUTCOME_TRY(ours, desk_.pick_up(made));
  const auto published = [&]() -> Status {
    for (const auto& file : files) {
      BOOST_OUTCOME_TRY(in_the_way, is_folder(to / file, FollowLinks::no));
      if (in_the_way) {  // which rename() cannot replace
        BOOST_OUTCOME_TRYV(remove_export(name, file));
      }
      BOOST_OUTCOME_TRYV(set_owner(desk_, to / file, job.caller()));
      BOOST_OUTCOME_TRYV(desk_.put_down(ours / file, to / file));
    }
    return sync_folder(to);
  }();
  if (!published) {
    static_cast<void>(desk_.put_down(ours, made));  // if this fails, a successor does it
    return published;
  }
  return remove_whole(ours);
}

Status ResultFolders::remove_export(std::string_view name, const std::string& file) {
  const auto exports = exports_folder(folder(name));
  const auto gone = removed_folder(exports, random_token());
  BOOST_OUTCOME_TRYV(desk_.move(exports / file, gone));
  BOOST_OUTCOME_TRYV(remove_whole(gone));
  return forget_owner(exports / file);
}

Result<fs::path> ResultFolders::take_away(std::string_view name) {
  auto gone = removed_folder(results_, random_token());
  BOOST_OUTCOME_TRYV(desk_.move(folder(name), gone));
  BOOST_OUTCOME_TRYV(sync_folder(results_));
  return gone;
}

}  // namespace tessera::service

#include "src/service/staging_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/random_token.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

// Names on a desk: of a file that is being written, and of a moved file with the path that it came from. Names in a
// data folder have no backslash (check_name()).
constexpr std::string_view written = "written-", on_its_way = "from-";
constexpr char slash_in_name = '\\';

fs::path name_of(const fs::path& from, const fs::path& area) {
  std::string name = from.lexically_relative(area).string();
  std::replace(name.begin(), name.end(), '/', slash_in_name);
  return std::string(on_its_way) + name;
}

// The path in the name; empty when it is no path in an area.
fs::path place_of(std::string name) {
  name.erase(0, on_its_way.size());
  std::replace(name.begin(), name.end(), slash_in_name, '/');
  const fs::path place = fs::path(name).lexically_normal();
  return place.empty() || place.is_absolute() || *place.begin() == ".." || *place.begin() == "." ? fs::path() : place;
}

}  // namespace

StagingFolder::StagingFolder(fs::path area, std::uint64_t term, StillOurs still_ours)
    : area_(std::move(area)),
      term_(term),
      still_ours_(std::move(still_ours)),
      desk_(staging_folder_path(area_, term)) {}

StagingFolder::~StagingFolder() {
  ::rmdir(desk_.c_str());  // fails while a file is under way: a successor puts it back
}

Result<std::unique_ptr<StagingFolder>> StagingFolder::lay(fs::path area, std::uint64_t term, StillOurs still_ours) {
  std::unique_ptr<StagingFolder> desk(new StagingFolder(std::move(area), term, std::move(still_ours)));
  if (::mkdir(desk->desk_.c_str(), 0777) != 0) return io_error(desk->desk_, "cannot be made", errno);
  // After the desk exists: a process that takes the lock from now on finds the desk, and clears it.
  BOOST_OUTCOME_TRYV(desk->still_ours_());
  BOOST_OUTCOME_TRY(names, sorted_names(desk->area_));
  for (const auto& name : names) {
    const auto other = term_of_staging_folder(name);
    if (!other || *other >= term) continue;
    BOOST_OUTCOME_TRYV(desk->clear(desk->area_ / name));
  }
  return desk;
}

// Repeats until the desk is removed: a process that does not know that it has lost the folder may still put files
// there.
Status StagingFolder::clear(const fs::path& desk) const {
  while (true) {
    FolderReader reader(desk);
    std::vector<std::string> names;
    while (const char* name = reader.next()) names.emplace_back(name);
    if (reader.error() == std::errc::no_such_file_or_directory) return success();
    if (reader.error()) return io_error(desk, "cannot be read", reader.error().value());
    for (const auto& name : names) {
      if (name.starts_with(written)) {
        BOOST_OUTCOME_TRYV(remove_file(desk / name));
      } else if (name.starts_with(on_its_way) && !place_of(name).empty()) {
        BOOST_OUTCOME_TRYV(put_back(desk / name));
      } else {
        return error(Errc::corrupt,
                     (desk / name).string() +
                         ": is not a file of tesserad, which cannot clear this folder; move the file elsewhere");
      }
    }
    if (::rmdir(desk.c_str()) == 0 || errno == ENOENT) return sync_folder(area_);
    if (errno != ENOTEMPTY && errno != EEXIST) return io_error(desk, "cannot be removed", errno);
    BOOST_OUTCOME_TRYV(still_ours_());
  }
}

Status StagingFolder::put_back(const fs::path& picked_up) const {
  const fs::path to = area_ / place_of(picked_up.filename().string());
  BOOST_OUTCOME_TRY(taken, is_there(to, FollowLinks::no));
  if (!taken) {
    // If the folder above is gone, too, the file is not needed.
    if (std::rename(picked_up.c_str(), to.c_str()) == 0) return success();
    if (errno != ENOENT && errno != ENOTDIR) return io_error(to, "cannot be put back", errno);
  }
  BOOST_OUTCOME_TRY(held, look_at(picked_up, FollowLinks::no));
  if (!held) return success();  // another process has put it back
  // The file had arrived before, or a newer one is in its place. A folder is renamed, because files that are not ours
  // must stay.
  if (!S_ISDIR(held->st_mode)) return remove_file(picked_up);
  return rename_file(picked_up, removed_folder(to.parent_path(), random_token()));
}

Status StagingFolder::rename(const fs::path& from, const fs::path& to) const {
  if (std::rename(from.c_str(), to.c_str()) == 0) return success();
  const int reason = errno;
  BOOST_OUTCOME_TRYV(still_ours_());  // this error is clearer
  return io_error(to, "cannot rename to it", reason);
}

Status StagingFolder::write(const fs::path& final_name, std::string_view text) {
  BOOST_OUTCOME_TRYV(still_ours_());
  const fs::path path = desk_ / (std::string(written) + std::to_string(files_++));
  const auto moved = [&]() -> Status {
    BOOST_OUTCOME_TRY(file, open_handle(path, O_WRONLY | O_CREAT | O_EXCL, final_name));
    BOOST_OUTCOME_TRYV(write_on(file.get(), std::as_bytes(std::span(text)), final_name));
    if (::fsync(file.get()) != 0 || !file.close()) return io_error(final_name, "cannot write", errno);
    return rename(path, final_name);
  }();
  if (!moved) {
    ::unlink(path.c_str());  // the first error is reported
    return moved.error();
  }
  return sync_folder(final_name.parent_path());
}

Result<fs::path> StagingFolder::pick_up(const fs::path& from) {
  BOOST_OUTCOME_TRYV(still_ours_());
  auto picked_up = desk_ / name_of(from, area_);
  BOOST_OUTCOME_TRYV(rename(from, picked_up));
  return picked_up;
}

Status StagingFolder::put_down(const fs::path& picked_up, const fs::path& to) { return rename(picked_up, to); }

Status StagingFolder::move(const fs::path& from, const fs::path& to) {
  BOOST_OUTCOME_TRY(picked_up, pick_up(from));
  const Status moved = put_down(picked_up, to);
  // Tries to put it back at once; a successor that finds the desk does the same.
  if (!moved) std::rename(picked_up.c_str(), from.c_str());
  return moved;
}

}  // namespace tessera::service

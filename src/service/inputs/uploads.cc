#include "src/service/inputs/uploads.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <system_error>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"
#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/job/report/human.h"
#include "src/service/naming.h"
#include "src/service/problem.h"
#include "src/service/processes/costs.h"
#include "src/service/results/owners.h"

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

// 0 when there is no such file.
Result<std::uint64_t> bytes_of(const fs::path& file) {
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(file, FollowLinks::no));
  return bytes.value_or(0);
}

bool is_part(std::string_view name) { return name.starts_with('.') && name.ends_with(".part"); }
// REQUIRES: `part` is the path of a partial upload.
fs::path whole_of_part(const fs::path& part) {
  const std::string name = part.filename().string();
  return part.parent_path() / name.substr(1, name.size() - 1 - std::string_view(".part").size());
}

proto::Problem no_upload(std::string_view folder, std::string_view file) {
  return problem(404, "there is no upload '" + std::string(folder) + "/" + std::string(file) + "'", Errc::usage);
}

proto::Problem of_another(std::string_view folder, std::string_view file, const char* what) {
  return problem(403,
                 "upload '" + std::string(folder) + "/" + std::string(file) +
                     "': only the caller who sent it or an admin may " + what + " it",
                 Errc::usage);
}

}  // namespace

class Uploads::Sending final : public Upload {
 public:
  Sending(Uploads& uploads, fs::path path, FileHandle file)
      : uploads_(uploads), path_(std::move(path)), file_(std::move(file)) {}
  ~Sending() override {
    const std::lock_guard lock(uploads_.mutex_);
    uploads_.active_.erase(path_);
  }

  Reply<void> write(std::string_view bytes) override {
    {
      const std::lock_guard lock(uploads_.mutex_);
      const auto& limits = uploads_.limits_;
      if (limits.bytes > 0 && uploads_.used_.bytes + bytes.size() > limits.bytes) {
        return problem(507,
                       "all uploads together take " + human_bytes(uploads_.used_.bytes) + " of the " +
                           human_bytes(limits.bytes) +
                           " that they may take (limits.uploads): remove some that are not needed",
                       Errc::io);
      }
      const auto free = free_bytes(uploads_.data_);
      if (bytes.size() + limits.reserve_bytes > free) {
        return problem(507,
                       "the service's disk has " + human_bytes(free) + " free, and uploads must leave " +
                           human_bytes(limits.reserve_bytes) + " free (limits.reserve)",
                       Errc::io);
      }
      uploads_.used_.bytes += bytes.size();
    }
    const auto written = write_on(file_.get(), std::as_bytes(std::span(bytes)), path_);
    if (!written) return problem_of(written.error());
    return success();
  }

  Reply<void> finish() override {
    const auto finished = [&]() -> Status {
      BOOST_OUTCOME_TRY(replaced, bytes_if_there(path_, FollowLinks::no));
      const fs::path part = part_file(path_);
      const fs::path parts[] = {part};
      BOOST_OUTCOME_TRYV(sync_files(parts));
      BOOST_OUTCOME_TRYV(uploads_.desk_.move(part, path_));
      {
        const std::lock_guard lock(uploads_.mutex_);
        uploads_.gone(replaced.value_or(0), replaced.has_value());
      }
      return sync_folder(path_.parent_path());
    }();
    if (!finished) return problem_of(finished.error());
    return success();
  }

 private:
  Uploads& uploads_;
  const fs::path path_;
  const FileHandle file_;
};

Uploads::Uploads(fs::path data, const UploadLimits& limits, StagingFolder& desk)
    : data_(std::move(data)), limits_(limits), desk_(desk) {}

fs::path Uploads::folder() const { return uploads_folder(data_); }

Status Uploads::open() {
  BOOST_OUTCOME_TRYV(make_directories(folder()));
  BOOST_OUTCOME_TRY(bytes, used());
  used_ = bytes;
  return success();
}

Result<Uploads::Used> Uploads::used() const {
  Used used;
  FolderReader folders(folder());
  while (const char* name = folders.next()) {
    const auto below = folder() / name;
    BOOST_OUTCOME_TRY(is_one, is_folder(below, FollowLinks::no));
    if (!is_one || !check_name(name)) continue;  // desks
    FolderReader files(below);
    while (const char* file = files.next()) {
      if (!is_part(file) && !check_name(file)) continue;  // not an upload
      BOOST_OUTCOME_TRY(more, bytes_of(below / file));
      used.bytes += more;
      ++used.files;
    }
    if (files.error()) return io_error(below, "cannot be listed", files.error().value());
  }
  if (folders.error()) return io_error(folder(), "cannot be listed", folders.error().value());
  return used;
}

void Uploads::gone(std::uint64_t bytes, bool file) {
  used_.bytes -= std::min(used_.bytes, bytes);
  used_.files -= file && used_.files > 0 ? 1 : 0;
}

Result<std::optional<std::string>> Uploads::owner_or_none(const fs::path& path) const {
  BOOST_OUTCOME_TRY(whole, is_there(path, FollowLinks::no));
  BOOST_OUTCOME_TRY(part, is_there(part_file(path), FollowLinks::no));
  if (!whole && !part) return std::optional<std::string>();
  BOOST_OUTCOME_TRY(owner, owner_of(path));
  return std::optional(std::move(owner));
}

Reply<void> Uploads::remove(std::string_view folder, std::string_view file, const Caller& caller) {
  BOOST_OUTCOME_TRY(path, path_of(folder, file));
  const std::lock_guard lock(mutex_);
  const auto removed = [&]() -> Reply<void> {
    const auto owned = owner_or_none(path);
    if (!owned) return problem_of(owned.error());
    if (!owned.value()) return no_upload(folder, file);
    if (!may_remove(*owned.value(), caller)) return of_another(folder, file, "remove");
    if (active_.contains(path))
      return problem(409, "this upload is still being sent; remove it when that has ended", Errc::usage);
    // The owner last: until everything is gone, the file has an owner.
    if (const Status ours = desk_.still_ours(); !ours) return problem_of(ours.error());
    for (const auto& each : {part_file(path), path})
      if (const auto gone = remove_one(each); !gone) return problem_of(gone.error());
    if (const Status gone = forget_owner(path); !gone) return problem_of(gone.error());
    return success();
  }();
  std::error_code others;
  if (removed) fs::remove(path.parent_path(), others);  // fails, as it should, unless it is empty
  return removed;
}

Result<bool> Uploads::remove_one(const fs::path& file) {
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(file, FollowLinks::no));
  if (!bytes) return false;
  // Through the staging folder, so that a daemon that has lost the data folder removes nothing from its successor.
  BOOST_OUTCOME_TRY(picked_up, desk_.pick_up(file));
  BOOST_OUTCOME_TRYV(remove_file(picked_up));
  gone(*bytes, true);
  return true;
}

std::vector<std::string> Uploads::expire(std::chrono::system_clock::time_point before) {
  std::vector<std::string> told;
  FolderReader folders(folder());
  while (const char* name = folders.next()) {
    const auto below = is_folder(folder() / name, FollowLinks::no);
    if (!below) told.push_back(below.error().where);
    if (!below || !below.value()) continue;
    FolderReader files(folder() / name);
    while (const char* file = files.next()) {
      if (!is_part(file)) continue;
      const std::lock_guard lock(mutex_);
      const auto expired = expire_one(folder() / name / file, before);
      if (!expired) told.push_back(expired.error().where);
      if (expired && expired.value())
        told.push_back((folder() / name / file).string() +
                       ": was removed, because nobody has sent the rest of this upload");
    }
  }
  return told;
}

Result<bool> Uploads::expire_one(const fs::path& part, std::chrono::system_clock::time_point before) {
  if (std::any_of(active_.begin(), active_.end(), [&](const auto& sent) { return part_file(sent) == part; }))
    return false;
  BOOST_OUTCOME_TRY(found, look_at(part, FollowLinks::no));
  if (!found || std::chrono::system_clock::from_time_t(found->st_mtime) >= before) return false;
  BOOST_OUTCOME_TRYV(desk_.still_ours());
  BOOST_OUTCOME_TRY(removed, remove_one(part));
  const fs::path path = whole_of_part(part);
  BOOST_OUTCOME_TRY(whole, is_there(path, FollowLinks::no));
  if (!whole) {
    BOOST_OUTCOME_TRYV(forget_owner(path));
    std::error_code others;
    fs::remove(path.parent_path(), others);  // fails, as it should, unless it is empty
  }
  return removed;
}

Reply<fs::path> Uploads::path_of(std::string_view folder, std::string_view file) const {
  for (const auto name : {folder, file}) {
    if (const auto fits = check_name(name); !fits)
      return problem(400, "the name '" + std::string(name) + "' " + fits.error().where, Errc::usage);
  }
  return this->folder() / std::string(folder) / std::string(file);
}

Reply<std::uint64_t> Uploads::uploaded(std::string_view folder, std::string_view file) const {
  BOOST_OUTCOME_TRY(path, path_of(folder, file));
  for (const auto& file : {part_file(path), path}) {
    const auto bytes = bytes_if_there(file, FollowLinks::no);
    if (!bytes) return problem_of(bytes.error());
    if (bytes.value()) return *bytes.value();
  }
  return no_upload(folder, file);
}

Reply<std::unique_ptr<Upload>> Uploads::begin(std::string_view folder, std::string_view file, std::uint64_t offset,
                                              const Caller& caller) {
  BOOST_OUTCOME_TRY(path, path_of(folder, file));
  const std::lock_guard lock(mutex_);
  if (active_.contains(path)) return problem(409, "this upload is being sent already, in another request", Errc::usage);
  const auto sent = bytes_if_there(part_file(path), FollowLinks::no);
  if (!sent) return problem_of(sent.error());
  const auto there = sent.value().value_or(0);
  const auto owned = owner_or_none(path);
  if (!owned) return problem_of(owned.error());
  const std::string owner = owned.value().value_or("");
  if (owned.value() && !may_remove(owner, caller)) return of_another(folder, file, "replace");
  if (offset != 0 && offset != there) {
    return problem(409,
                   "offset " + std::to_string(offset) + ": " + std::to_string(there) +
                       " bytes have arrived so far; go on from there, or from 0",
                   Errc::usage);
  }
  const bool is_new = !sent.value();
  if (is_new && used_.files >= limits_.files)
    return problem(
        507, "there are " + grouped(used_.files) + " uploaded files, which is the most that are allowed: remove some",
        Errc::io);
  const auto opened = [&]() -> Result<FileHandle> {
    std::error_code failed;
    if (fs::create_directory(path.parent_path(), failed); failed)
      return error(Errc::io, path.parent_path().string() + ": cannot be made: " + failed.message());
    if (owner != caller.name) {
      BOOST_OUTCOME_TRYV(set_owner(desk_, path, caller.name));
    }
    const int again = offset == 0 ? O_TRUNC : O_APPEND;
    return open_handle(part_file(path), O_WRONLY | O_CREAT | O_NOFOLLOW | again, path);
  };
  auto handle = opened();
  if (!handle) return problem_of(handle.error());
  if (offset == 0) gone(there, false);
  used_.files += is_new ? 1 : 0;
  active_.insert(path);
  return std::unique_ptr<Upload>(std::make_unique<Sending>(*this, std::move(path), std::move(handle).value()));
}

}  // namespace tessera::service

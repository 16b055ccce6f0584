#include "src/service/uploads.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <span>
#include <system_error>
#include <utility>

#include "src/files/descriptor.h"
#include "src/files/folder.h"
#include "src/files/names.h"
#include "src/files/there.h"
#include "src/files/whole_file.h"
#include "src/report/human.h"
#include "src/service/naming.h"
#include "src/service/owners.h"
#include "src/service/problem.h"

namespace tessera {
namespace fs = std::filesystem;
namespace {

// 0 when there is no such file.
Result<std::uint64_t> bytes_of(const fs::path& file) {
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(file, FollowLinks::no));
  return bytes.value_or(0);
}

}  // namespace

class Uploads::Sending final : public Service::Upload {
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
      if (uploads_.bytes_max_ > 0 && uploads_.used_ + bytes.size() > uploads_.bytes_max_) {
        return problem(507,
                       "uploads hold " + human_bytes(uploads_.used_) + " of the " + human_bytes(uploads_.bytes_max_) +
                           " that they may",
                       Errc::io);
      }
      uploads_.used_ += bytes.size();
    }
    const auto written = write_on(file_.get(), std::as_bytes(std::span(bytes)), path_);
    if (!written) return problem_of(written.error());
    return success();
  }

  Reply<void> finish() override {
    const auto finished = [&]() -> Status {
      BOOST_OUTCOME_TRY(replaced, bytes_of(path_));
      const fs::path part = part_file(path_);
      const fs::path parts[] = {part};
      BOOST_OUTCOME_TRYV(sync_files(parts));
      BOOST_OUTCOME_TRYV(uploads_.desk_.move(part, path_));
      {
        const std::lock_guard lock(uploads_.mutex_);
        uploads_.used_ -= std::min(uploads_.used_, replaced);
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

Uploads::Uploads(fs::path data, std::uint64_t bytes_max, Desk& desk)
    : data_(std::move(data)), bytes_max_(bytes_max), desk_(desk) {}

fs::path Uploads::folder() const { return uploads_folder(data_); }

Status Uploads::open() {
  BOOST_OUTCOME_TRYV(make_directories(folder()));
  BOOST_OUTCOME_TRY(bytes, used());
  used_ = bytes;
  return success();
}

Result<std::uint64_t> Uploads::used() const {
  std::uint64_t bytes = 0;
  FolderReader folders(folder());
  while (const char* name = folders.next()) {
    const auto below = folder() / name;
    BOOST_OUTCOME_TRY(is_one, is_folder(below, FollowLinks::no));
    if (!is_one) continue;
    FolderReader files(below);
    while (const char* file = files.next()) {
      BOOST_OUTCOME_TRY(more, bytes_of(below / file));
      bytes += more;
    }
    if (files.error()) return io_error(below, "cannot be listed", files.error().value());
  }
  if (folders.error()) return io_error(folder(), "cannot be listed", folders.error().value());
  return bytes;
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
  return problem(404, "there is no upload '" + std::string(folder) + "/" + std::string(file) + "'", Errc::usage);
}

Reply<std::unique_ptr<Service::Upload>> Uploads::begin(std::string_view folder, std::string_view file,
                                                       std::uint64_t offset, const Caller& caller) {
  BOOST_OUTCOME_TRY(path, path_of(folder, file));
  const std::lock_guard lock(mutex_);
  if (active_.contains(path)) return problem(409, "this file is being sent already", Errc::usage);
  const auto sent = bytes_of(part_file(path));
  if (!sent) return problem_of(sent.error());
  const auto there = sent.value();
  // Of the file, or of what has come of it; empty when there is neither.
  const auto known = [&]() -> Result<std::optional<std::string>> {
    BOOST_OUTCOME_TRY(whole, is_there(path, FollowLinks::no));
    BOOST_OUTCOME_TRY(part, is_there(part_file(path), FollowLinks::no));
    if (!whole && !part) return std::optional<std::string>();
    BOOST_OUTCOME_TRY(found, owner_of(path));
    return std::optional(std::move(found));
  }();
  if (!known) return problem_of(known.error());
  std::string owner;
  if (known.value()) {
    owner = *known.value();
    if (!may_remove(owner, caller))
      return problem(
          403, "upload '" + std::string(folder) + "/" + std::string(file) + "': who sent it or an admin may replace it",
          Errc::usage);
  }
  if (offset != 0 && offset != there) {
    return problem(409, "offset " + std::to_string(offset) + ": " + std::to_string(there) + " bytes have come so far",
                   Errc::usage);
  }
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
  if (offset == 0) used_ -= std::min(used_, there);
  active_.insert(path);
  return std::unique_ptr<Service::Upload>(std::make_unique<Sending>(*this, std::move(path), std::move(handle).value()));
}

}  // namespace tessera

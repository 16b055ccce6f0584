#include "src/service/uploads.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
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
#include "src/service/costs.h"
#include "src/service/naming.h"
#include "src/service/problem.h"

namespace tessera {
namespace fs = std::filesystem;
namespace {

// 0 when there is no such file.
Result<std::uint64_t> bytes_of(const fs::path& file) {
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(file, FollowLinks::no));
  return bytes.value_or(0);
}

bool is_part(std::string_view name) { return name.starts_with('.') && name.ends_with(".part"); }

proto::Problem no_upload(std::string_view folder, std::string_view file) {
  return problem(404, "there is no upload '" + std::string(folder) + "/" + std::string(file) + "'", Errc::usage);
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
      const auto& limits = uploads_.limits_;
      if (limits.bytes > 0 && uploads_.used_.bytes + bytes.size() > limits.bytes) {
        return problem(507,
                       "uploads hold " + human_bytes(uploads_.used_.bytes) + " of the " + human_bytes(limits.bytes) +
                           " that they may (limits.uploads)",
                       Errc::io);
      }
      const auto free = free_bytes(uploads_.data_);
      if (bytes.size() + limits.reserve_bytes > free) {
        return problem(507,
                       "the disk has " + human_bytes(free) + " left, of which uploads leave " +
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
      BOOST_OUTCOME_TRYV(publish(part_file(path_), path_));
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

Uploads::Uploads(fs::path data, const UploadLimits& limits) : data_(std::move(data)), limits_(limits) {}

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
    if (!is_one) continue;
    FolderReader files(below);
    while (const char* file = files.next()) {
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

Reply<void> Uploads::remove(std::string_view folder, std::string_view file) {
  BOOST_OUTCOME_TRY(path, path_of(folder, file));
  const std::lock_guard lock(mutex_);
  if (active_.contains(path)) return problem(409, "this file is being sent", Errc::usage);
  bool any = false;
  for (const auto& each : {part_file(path), path}) {
    const auto removed = remove_one(each);
    if (!removed) return problem_of(removed.error());
    any = any || removed.value();
  }
  return any ? Reply<void>(success()) : no_upload(folder, file);
}

Result<bool> Uploads::remove_one(const fs::path& file) {
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(file, FollowLinks::no));
  if (!bytes) return false;
  BOOST_OUTCOME_TRYV(remove_file(file));
  gone(*bytes, true);
  std::error_code others;
  fs::remove(file.parent_path(), others);  // stays when anything is in it
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
        told.push_back((folder() / name / file).string() + ": nobody went on sending it; removed");
    }
  }
  return told;
}

Result<bool> Uploads::expire_one(const fs::path& part, std::chrono::system_clock::time_point before) {
  if (std::any_of(active_.begin(), active_.end(), [&](const auto& sent) { return part_file(sent) == part; }))
    return false;
  BOOST_OUTCOME_TRY(found, look_at(part, FollowLinks::no));
  if (!found || std::chrono::system_clock::from_time_t(found->st_mtime) >= before) return false;
  return remove_one(part);
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

Reply<std::unique_ptr<Service::Upload>> Uploads::begin(std::string_view folder, std::string_view file,
                                                       std::uint64_t offset) {
  BOOST_OUTCOME_TRY(path, path_of(folder, file));
  const std::lock_guard lock(mutex_);
  if (active_.contains(path)) return problem(409, "this file is being sent already", Errc::usage);
  const auto sent = bytes_if_there(part_file(path), FollowLinks::no);
  if (!sent) return problem_of(sent.error());
  const auto there = sent.value().value_or(0);
  if (offset != 0 && offset != there) {
    return problem(409, "offset " + std::to_string(offset) + ": " + std::to_string(there) + " bytes have come so far",
                   Errc::usage);
  }
  const bool is_new = !sent.value();
  if (is_new && used_.files >= limits_.files)
    return problem(507, "uploads are " + grouped(used_.files) + " files, as many as may be", Errc::io);
  const auto opened = [&]() -> Result<FileHandle> {
    std::error_code failed;
    if (fs::create_directory(path.parent_path(), failed); failed)
      return error(Errc::io, path.parent_path().string() + ": cannot be made: " + failed.message());
    const int again = offset == 0 ? O_TRUNC : O_APPEND;
    return open_handle(part_file(path), O_WRONLY | O_CREAT | O_NOFOLLOW | again, path);
  };
  auto handle = opened();
  if (!handle) return problem_of(handle.error());
  if (offset == 0) gone(there, false);
  used_.files += is_new ? 1 : 0;
  active_.insert(path);
  return std::unique_ptr<Service::Upload>(std::make_unique<Sending>(*this, std::move(path), std::move(handle).value()));
}

}  // namespace tessera

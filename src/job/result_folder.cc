#include "src/job/result_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "src/store/tile_store.h"

namespace tessera {
namespace fs = std::filesystem;
namespace {

bool is_run(const fs::path& folder) {
  std::error_code ec;
  return fs::is_regular_file(folder / "plan.json", ec);
}

// The names finish_store, write_tile and the report make, temporary ones included.
bool is_ours(const fs::path& file) {
  std::string name = file.filename().string();
  if (const auto at = name.find(".tmp"); at != std::string::npos) name.resize(at);
  return name == "manifest.json" || name == "triangulation.vtkhdf" || name == "duplicates.bin" || name == "report.html";
}

bool is_our_tile(const fs::path& file) {
  const auto name = file.filename().string();
  return name.size() > 7 && std::all_of(name.begin(), name.begin() + 6, [](char c) { return c >= '0' && c <= '9'; });
}

Error refused_by_system(const fs::path& path, const std::string& reason) {
  return error(Errc::io, path.string() + ": " + reason);
}

}  // namespace

Result<ResultFolder> ResultFolder::inspect(fs::path out, bool resume, bool overwrite) {
  std::error_code ec;
  const auto status = fs::status(out, ec);
  if (!fs::exists(status)) {
    if (ec && ec != std::errc::no_such_file_or_directory) return refused_by_system(out, ec.message());
    auto parent = fs::absolute(out, ec);
    if (!parent.has_filename()) parent = parent.parent_path();  // "out/"
    parent = parent.parent_path();
    if (!fs::is_directory(parent, ec)) return refused_by_system(out, "the folder it would stand in does not exist");
    return ResultFolder(std::move(out), FolderState::absent, false);
  }
  if (!fs::is_directory(status)) return refused_by_system(out, "is not a folder");

  bool anything = false;
  fs::directory_iterator entries(out, ec);
  if (ec) return refused_by_system(out, "cannot be read: " + ec.message());
  for (; entries != fs::directory_iterator(); entries.increment(ec)) {
    if (ec) return refused_by_system(out, "cannot be read: " + ec.message());
    anything = anything || entries->path().filename() != ".run.new";
  }
  const bool manifest = fs::exists(out / "manifest.json", ec);
  if (manifest) {
    // A damaged or newer manifest is nothing to build on, nor to delete: its owner decides.
    const auto read = read_manifest(out);
    if (!read) return read.error();
    if (resume && is_run(out / ".run")) return ResultFolder(std::move(out), FolderState::finished, true);
    if (!overwrite) {
      return error(Errc::usage, out.string() + ": holds a finished result; --overwrite replaces it");
    }
    return ResultFolder(std::move(out), FolderState::finished, false);
  }
  if (is_run(out / ".run")) {
    if (!resume && !overwrite) {
      return error(Errc::usage,
                   out.string() + ": holds an unfinished run; --resume continues it, --overwrite starts again");
    }
    return ResultFolder(std::move(out), FolderState::unfinished, resume);
  }
  if (anything) {
    return error(Errc::usage, out.string() + ": is not empty and holds no result of ours; choose another folder");
  }
  return ResultFolder(std::move(out), FolderState::empty, false);
}

ResultFolder::ResultFolder(ResultFolder&& other) noexcept
    : out_(std::move(other.out_)),
      state_(other.state_),
      resuming_(other.resuming_),
      created_(other.created_),
      old_result_stands_(other.old_result_stands_),
      complete_(other.complete_),
      lock_(std::exchange(other.lock_, -1)) {}

ResultFolder::~ResultFolder() {
  if (lock_ >= 0) close(lock_);
}

Status ResultFolder::claim() {
  std::error_code ec;
  if (state_ == FolderState::absent) {
    created_ = fs::create_directory(out_, ec);
    if (ec) return refused_by_system(out_, "cannot be made: " + ec.message());
  }
  lock_ = open(out_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) return refused_by_system(out_, std::strerror(errno));
  if (flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    const int reason = errno;
    close(std::exchange(lock_, -1));
    if (reason == EWOULDBLOCK) return error(Errc::usage, out_.string() + ": another tessera is at work in it");
    return refused_by_system(out_, std::string("cannot be locked: ") + std::strerror(reason));
  }
  if (access(out_.c_str(), W_OK | X_OK) != 0) {
    return refused_by_system(out_, std::string("cannot be written: ") + std::strerror(errno));
  }
  old_result_stands_ = state_ == FolderState::finished;
  return success();
}

Status ResultFolder::discard_runs() {
  std::error_code ec;
  fs::remove_all(new_run(), ec);
  if (ec) return refused_by_system(new_run(), "cannot be removed: " + ec.message());
  if (!resuming_ && is_run(run())) {
    fs::remove_all(run(), ec);
    if (ec) return refused_by_system(run(), "cannot be removed: " + ec.message());
  }
  return success();
}

Status ResultFolder::remove_result() const {
  std::error_code ec;
  // The manifest first: without it nobody takes the rest for a result.
  fs::remove(out_ / "manifest.json", ec);
  if (ec) return refused_by_system(out_ / "manifest.json", "cannot be removed: " + ec.message());
  const auto remove_from = [&](const fs::path& folder, bool (*ours)(const fs::path&)) -> Status {
    if (!fs::is_directory(fs::symlink_status(folder, ec))) return success();
    std::vector<fs::path> files;
    for (fs::directory_iterator it(folder, ec); !ec && it != fs::directory_iterator(); it.increment(ec)) {
      if (!fs::is_directory(it->symlink_status(ec)) && ours(it->path())) files.push_back(it->path());
    }
    for (const auto& file : files) {
      if (!ec) fs::remove(file, ec);
    }
    if (ec) return refused_by_system(folder, "cannot be cleared: " + ec.message());
    return success();
  };
  BOOST_OUTCOME_TRYV(remove_from(out_, is_ours));
  BOOST_OUTCOME_TRYV(remove_from(out_ / "tiles", is_our_tile));
  fs::remove(out_ / "tiles", ec);  // stays when somebody else's files are in it
  return success();
}

Status ResultFolder::accept_new_run() {
  BOOST_OUTCOME_TRYV(remove_result());
  old_result_stands_ = false;
  std::error_code ec;
  fs::rename(new_run(), run(), ec);
  if (ec) return refused_by_system(run(), "cannot be made: " + ec.message());
  return success();
}

Status ResultFolder::finish() {
  complete_ = true;
  std::error_code ec;
  fs::remove_all(run(), ec);
  if (ec) return refused_by_system(run(), "cannot be removed: " + ec.message());
  return success();
}

void ResultFolder::abandon() {
  std::error_code ignored;  // see the header
  // Without the lock another process may be at work.
  if (complete_ || lock_ < 0) return;
  fs::remove_all(new_run(), ignored);
  if (resuming_) return;
  if (!old_result_stands_) {
    if (is_run(run())) fs::remove_all(run(), ignored);
    if (const auto removed = remove_result(); !removed) return;
  }
  if (created_) fs::remove(out_, ignored);  // only when empty
}

bool ResultFolder::interrupted() {
  if (is_run(run())) return true;
  abandon();
  return false;
}

}  // namespace tessera

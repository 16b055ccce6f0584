#include "src/base/files/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "src/base/files/disk_file.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"

namespace tessera {

namespace fs = std::filesystem;

Status make_directories(const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return io_error(folder, "cannot make the folder", code.value());
  return success();
}

Status remove_file(const fs::path& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return io_error(path, "cannot remove", errno);
  return success();
}

Status rename_file(const fs::path& from, const fs::path& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) return io_error(to, "cannot rename to it", errno);
  return success();
}

namespace {

Status sync_path(const fs::path& path, int flags) {
  BOOST_OUTCOME_TRY(file, open_handle(path, flags));
  // Some file systems cannot sync a folder and return EINVAL. The renaming is then as durable as they make it.
  if (::fsync(file.get()) != 0 && !(errno == EINVAL && (flags & O_DIRECTORY) != 0))
    return io_error(path, "cannot write", errno);
  if (!file.close()) return io_error(path, "cannot write", errno);
  return success();
}

}  // namespace

Status publish(const fs::path& temporary, const fs::path& final_name) {
  BOOST_OUTCOME_TRYV(sync_path(temporary, O_RDWR));
  return rename_file(temporary, final_name);
}

Status sync_folder(const fs::path& folder) {
  return sync_path(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY);
}

Status sync_files(std::span<const fs::path> files) {
  constexpr std::size_t threads_max = 16;
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  Status done = success();
  std::exception_ptr thrown;
  const auto sync_some = [&] {
    for (std::size_t i = next++; i < files.size(); i = next++) {
      try {
        const Status synced = sync_path(files[i], O_RDWR);
        const std::lock_guard lock(mutex);
        if (done) done = synced;
      } catch (...) {
        const std::lock_guard lock(mutex);
        thrown = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t t = 1; t < std::min(threads_max, files.size()); ++t) others.emplace_back(sync_some);
    sync_some();
  }
  if (thrown) std::rethrow_exception(thrown);
  return done;
}

namespace {

Status write_whole(const fs::path& final_name, std::span<const std::byte> bytes, int flags, mode_t rights) {
  TemporaryFile temporary(temporary_name(final_name));
  {
    BOOST_OUTCOME_TRY(file, open_handle(temporary.path(), O_WRONLY | O_CREAT | flags, final_name, rights));
    BOOST_OUTCOME_TRYV(write_on(file.get(), bytes, final_name));
    if (!file.close()) return io_error(final_name, "cannot write", errno);
  }
  BOOST_OUTCOME_TRYV(publish(temporary.path(), final_name));
  temporary.keep();
  return sync_folder(final_name.parent_path());
}

}  // namespace

Status write_whole(const fs::path& final_name, std::span<const std::byte> bytes) {
  return write_whole(final_name, bytes, O_TRUNC, 0666);
}

Status write_private(const fs::path& final_name, std::span<const std::byte> bytes) {
  // A file that is left of a killed process may be open elsewhere, or have other rights.
  BOOST_OUTCOME_TRYV(remove_file(temporary_name(final_name)));
  return write_whole(final_name, bytes, O_EXCL, S_IRUSR | S_IWUSR);
}

Status write_whole(const fs::path& final_name, std::string_view text) {
  return write_whole(final_name, std::as_bytes(std::span(text)));
}

Result<std::vector<std::byte>> read_whole(const fs::path& path) {
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  BOOST_OUTCOME_TRY(size, file.size());
  std::vector<std::byte> bytes(size);
  BOOST_OUTCOME_TRY(done, file.read(bytes));
  bytes.resize(done);
  return bytes;
}

}  // namespace tessera

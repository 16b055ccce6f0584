#include "src/store/files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace tessera::store {

namespace fs = std::filesystem;

Error io_error(const fs::path& path, const std::string& what, int number) {
  return error(Errc::io, path.string() + ": " + what + ": " + std::strerror(number));
}

FileHandle& FileHandle::operator=(FileHandle&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

FileHandle::~FileHandle() { close(); }

bool FileHandle::close() {
  if (fd_ < 0) return true;
  const int result = ::close(fd_);
  fd_ = -1;
  return result == 0;
}

TemporaryFile::~TemporaryFile() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Result<MemoryFile> MemoryFile::create(std::uint64_t bytes_max, const fs::path& path) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < bytes_max)
    return io_error(path, "cannot write", EFBIG);
  FileHandle file(::memfd_create("tessera", MFD_CLOEXEC));
  if (file.get() < 0) return io_error(path, "cannot make a file in memory", errno);
  return MemoryFile(std::move(file), path);
}

Result<std::uint64_t> MemoryFile::size() const {
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) return io_error(path_, "cannot read back", errno);
  return static_cast<std::uint64_t>(status.st_size);
}

Result<std::vector<std::byte>> MemoryFile::read(std::uint64_t begin, std::uint64_t end) const {
  std::vector<std::byte> bytes(end - begin);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto n = ::pread(file_.get(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(begin + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return io_error(path_, "cannot read back", n < 0 ? errno : EIO);
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

fs::path temporary_name(const fs::path& final_name) {
  fs::path name = final_name;
  name += ".tmp";
  return name;
}

Status make_directories(const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return error(Errc::io, folder.string() + ": cannot make the folder: " + code.message());
  return success();
}

namespace {

Status sync_path(const fs::path& path, int flags) {
  FileHandle file(::open(path.c_str(), flags | O_CLOEXEC));
  if (file.get() < 0) return io_error(path, "cannot open", errno);
  // Some file systems cannot sync a folder and say EINVAL; the rename is then as durable as they make it.
  if (::fsync(file.get()) != 0 && !(errno == EINVAL && (flags & O_DIRECTORY) != 0))
    return io_error(path, "cannot write", errno);
  if (!file.close()) return io_error(path, "cannot write", errno);
  return success();
}

}  // namespace

Status publish(const fs::path& temporary, const fs::path& final_name) {
  BOOST_OUTCOME_TRYV(sync_path(temporary, O_RDWR));
  if (::rename(temporary.c_str(), final_name.c_str()) != 0) return io_error(final_name, "cannot rename to it", errno);
  return success();
}

Status sync_folder(const fs::path& folder) {
  return sync_path(folder.empty() ? fs::path(".") : folder, O_RDONLY | O_DIRECTORY);
}

Status write_at(int fd, std::span<const std::byte> bytes, std::uint64_t offset, const fs::path& path) {
  constexpr std::size_t piece = std::size_t{1} << 30;  // Linux writes at most 2 GiB a call
  while (!bytes.empty()) {
    const auto n = ::pwrite(fd, bytes.data(), std::min(bytes.size(), piece), static_cast<off_t>(offset));
    if (n < 0) {
      if (errno == EINTR) continue;
      return io_error(path, "cannot write", errno);
    }
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return success();
}

Status write_whole(const fs::path& final_name, std::span<const std::byte> bytes) {
  TemporaryFile temporary(temporary_name(final_name));
  {
    FileHandle file(::open(temporary.path().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
    if (file.get() < 0) return io_error(final_name, "cannot create", errno);
    BOOST_OUTCOME_TRYV(write_at(file.get(), bytes, 0, final_name));
    if (!file.close()) return io_error(final_name, "cannot write", errno);
  }
  BOOST_OUTCOME_TRYV(publish(temporary.path(), final_name));
  temporary.keep();
  return sync_folder(final_name.parent_path());
}

Status write_whole(const fs::path& final_name, std::string_view text) {
  return write_whole(final_name, std::as_bytes(std::span(text.data(), text.size())));
}

Result<std::vector<std::byte>> read_whole(const fs::path& path) {
  FileHandle file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return io_error(path, "cannot open", errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return io_error(path, "cannot read", errno);
  if (!S_ISREG(status.st_mode)) return error(Errc::io, path.string() + ": is not a file");
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto n = ::read(file.get(), bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return io_error(path, "cannot read", errno);
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace tessera::store

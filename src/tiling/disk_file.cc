#include "src/tiling/disk_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace tessera {

Error system_error(const std::filesystem::path& path, const char* what, int code) {
  return error(Errc::io, path.string() + ": " + what + ": " + std::generic_category().message(code));
}

Result<DiskFile> DiskFile::open(const std::filesystem::path& path, Mode mode) {
  const int flags = mode == Mode::read     ? O_RDONLY
                    : mode == Mode::append ? O_WRONLY | O_CREAT | O_APPEND
                                           : O_WRONLY | O_CREAT | O_TRUNC;
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
  if (fd < 0) return system_error(path, mode == Mode::read ? "cannot open" : "cannot create", errno);
  return DiskFile(path, fd);
}

DiskFile::~DiskFile() {
  if (fd_ >= 0) ::close(fd_);  // after an error that has been reported, or after reading
}

Result<std::uint64_t> DiskFile::size() const {
  struct stat status {};
  if (::fstat(fd_, &status) != 0) return system_error(path_, "cannot read its size", errno);
  if (!S_ISREG(status.st_mode)) return error(Errc::io, path_.string() + ": is not a file");
  return static_cast<std::uint64_t>(status.st_size);
}

Result<std::size_t> DiskFile::read(std::span<std::byte> buffer) {
  std::size_t done = 0;
  while (done < buffer.size()) {
    const ssize_t n = ::read(fd_, buffer.data() + done, buffer.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path_, "cannot read", errno);
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

Status DiskFile::write(std::span<const std::byte> bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(fd_, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return system_error(path_, "cannot write", errno);
    done += static_cast<std::size_t>(n);
  }
  return success();
}

Status DiskFile::sync() {
  if (::fsync(fd_) != 0) return system_error(path_, "cannot write", errno);
  return success();
}

Status DiskFile::close() {
  if (::close(std::exchange(fd_, -1)) != 0) return system_error(path_, "cannot write", errno);
  return success();
}

Result<MappedFile> MappedFile::open(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return system_error(path, "cannot open", errno);
  struct stat status {};
  const int stat_failed = ::fstat(fd, &status) != 0 ? errno : 0;
  const auto size = static_cast<std::size_t>(status.st_size);
  void* at = MAP_FAILED;
  int map_failed = 0;
  if (stat_failed == 0 && size > 0) {
    at = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
    map_failed = at == MAP_FAILED ? errno : 0;
  }
  ::close(fd);  // the mapping stays
  if (stat_failed != 0) return system_error(path, "cannot read its size", stat_failed);
  if (map_failed != 0) return system_error(path, "cannot map", map_failed);
  if (size == 0) return MappedFile({});
  return MappedFile({static_cast<const std::byte*>(at), size});
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Status write_atomically(const std::filesystem::path& path, const std::string& text) {
  auto temporary = path;
  temporary += ".tmp";
  {
    BOOST_OUTCOME_TRY(file, DiskFile::open(temporary, DiskFile::Mode::replace));
    BOOST_OUTCOME_TRYV(file.write(std::as_bytes(std::span(text))));
    BOOST_OUTCOME_TRYV(file.sync());
    BOOST_OUTCOME_TRYV(file.close());
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) return system_error(path, "cannot create", errno);
  // The name is on disk once its folder is.
  const auto folder = path.parent_path().empty() ? std::filesystem::path(".") : path.parent_path();
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return system_error(folder, "cannot open", errno);
  const int failed = ::fsync(fd) != 0 ? errno : 0;
  ::close(fd);
  // Some file systems cannot sync a folder and say so with EINVAL; they offer nothing better.
  if (failed != 0 && failed != EINVAL) return system_error(folder, "cannot write", failed);
  return success();
}

}  // namespace tessera

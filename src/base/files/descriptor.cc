#include "src/base/files/descriptor.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/ledger.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 30;  // Linux transfers at most 2 GiB a call

// Checks what was opened without waiting. O_NONBLOCK is removed again from what is not a file, such as a terminal, so
// that writing waits.
Status check_kind(int fd, int flags, const fs::path& path) {
  if ((flags & (O_PATH | O_DIRECTORY)) != 0) return success();
  struct stat status {};
  if (::fstat(fd, &status) != 0) return io_error(path, "cannot be examined", errno);
  if (S_ISREG(status.st_mode)) return success();
  if ((flags & O_ACCMODE) == O_RDONLY || S_ISFIFO(status.st_mode))
    return error(Errc::io, path.string() + ": is not a regular file");
  const int now = (flags & O_NONBLOCK) != 0 ? -1 : ::fcntl(fd, F_GETFL);
  if (now >= 0) ::fcntl(fd, F_SETFL, now & ~O_NONBLOCK);
  return success();
}

}  // namespace

Error io_error(const fs::path& path, const std::string& what, int number) {
  return error(number == ENOMEM ? Errc::memory : Errc::io,
               path.string() + ": " + what + ": " + std::generic_category().message(number));
}

FileHandle& FileHandle::operator=(FileHandle&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

FileHandle::~FileHandle() { close(); }

bool FileHandle::close() {
  if (fd_ < 0) return true;
  return ::close(std::exchange(fd_, -1)) == 0;
}

Result<FileHandle> open_handle(const fs::path& path, int flags) { return open_handle(path, flags, path); }

Result<FileHandle> open_handle(const fs::path& path, int flags, const fs::path& final_name, mode_t rights) {
  while (true) {
    FileHandle file(::open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK, rights));
    if (file.get() >= 0) {
      BOOST_OUTCOME_TRYV(check_kind(file.get(), flags, final_name));
      return file;
    }
    // ENXIO: a named pipe without a reader.
    if (errno == ENXIO) return error(Errc::io, final_name.string() + ": is not a regular file");
    if (errno != EINTR) return io_error(final_name, (flags & O_CREAT) != 0 ? "cannot create" : "cannot open", errno);
  }
}

Status check_regular(const fs::path& path) {
  BOOST_OUTCOME_TRYV(open_handle(path, O_RDONLY));
  return success();
}

Result<FileHandle> nameless_file(const fs::path& folder) {
  FileHandle file(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  // Some network file systems, and kernels before 3.11, have no O_TMPFILE.
  if (file.get() < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL || errno == ENOENT)) {
    std::string name = (folder / ".tessera-XXXXXX").string();
    file = FileHandle(::mkostemp(name.data(), O_CLOEXEC));
    if (file.get() >= 0) ::unlink(name.c_str());
  }
  if (file.get() < 0) return io_error(folder, "a temporary file cannot be made", errno);
  return file;
}

Result<std::uint64_t> size_of(const FileHandle& file, const fs::path& path) {
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return io_error(path, "cannot read its size", errno);
  if (!S_ISREG(status.st_mode)) return error(Errc::io, path.string() + ": is not a regular file");
  return static_cast<std::uint64_t>(status.st_size);
}

Result<std::size_t> read_up_to(int fd, std::span<std::byte> buffer, std::uint64_t offset, const fs::path& path) {
  std::size_t done = 0;
  while (done < buffer.size()) {
    const auto n = ::pread(fd, buffer.data() + done, std::min(buffer.size() - done, piece_bytes),
                           static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return io_error(path, "cannot read", errno);
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  return done;
}

Status write_at(int fd, std::span<const std::byte> bytes, std::uint64_t offset, const fs::path& path,
                const char* what) {
  BOOST_OUTCOME_TRYV(Ledger::draw_write(bytes.size()));
  while (!bytes.empty()) {
    const auto n = ::pwrite(fd, bytes.data(), std::min(bytes.size(), piece_bytes), static_cast<off_t>(offset));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return io_error(path, what, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    offset += static_cast<std::uint64_t>(n);
  }
  return success();
}

Status write_on(int fd, std::span<const std::byte> bytes, const fs::path& path) {
  BOOST_OUTCOME_TRYV(Ledger::draw_write(bytes.size()));
  while (!bytes.empty()) {
    const auto n = ::write(fd, bytes.data(), std::min(bytes.size(), piece_bytes));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return io_error(path, "cannot write", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return success();
}

}  // namespace tessera

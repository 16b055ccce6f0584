#include "src/service/beneath.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace tessera::service {
namespace fs = std::filesystem;
namespace {

int openat2(int folder, const char* path, int flags, Links links) {
  struct open_how how {};
  how.flags = static_cast<unsigned>(flags | O_CLOEXEC);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS | (links == Links::refused ? RESOLVE_NO_SYMLINKS : 0);
  // EAGAIN: a folder on the way was renamed meanwhile.
  for (int attempt = 0;; ++attempt) {
    const auto fd = ::syscall(SYS_openat2, folder, path, &how, sizeof how);
    if (fd >= 0 || (errno != EAGAIN && errno != EINTR) || attempt == 100) return static_cast<int>(fd);
  }
}

}  // namespace

Result<std::optional<FileHandle>> open_if_there(const FileHandle& folder, const std::string& path, int flags,
                                                Links links) {
  if (path.find('\0') != std::string::npos) return error(Errc::usage, path + ": holds a zero byte");
  const int no_waiting = (flags & O_PATH) != 0 ? 0 : O_NOCTTY | O_NONBLOCK;  // openat2 refuses useless flags
  const int fd = openat2(folder.get(), path.c_str(), flags | no_waiting, links);
  if (fd >= 0) return std::optional(FileHandle(fd));
  const int number = errno;
  if (number == ENOENT || number == ENOTDIR) return std::optional<FileHandle>();
  if (number == EXDEV)
    return error(Errc::usage, path + ": leads out of the folder that may be read, through '..' or a link");
  if (number == ELOOP) {
    return error(Errc::usage, path + (links == Links::refused ? ": is a symbolic link, or goes through one"
                                                              : ": goes through links that form a circle"));
  }
  return io_error(path, "cannot be opened", number);
}

Result<FileHandle> open_beneath(const FileHandle& folder, const std::string& path, int flags, Links links) {
  BOOST_OUTCOME_TRY(opened, open_if_there(folder, path, flags, links));
  if (!opened) return io_error(path, "cannot be opened", ENOENT);
  return *std::move(opened);
}

Result<FileHandle> open_folder(const fs::path& folder) { return open_handle(folder, O_PATH | O_DIRECTORY); }

Result<fs::path> real_path(const FileHandle& file) {
  std::error_code failed;
  auto path = fs::read_symlink(path_of(file), failed);
  if (failed) return error(Errc::io, "the path of an open file cannot be read from /proc/self/fd: " + failed.message());
  return path;
}

fs::path path_of(const FileHandle& file) { return "/proc/self/fd/" + std::to_string(file.get()); }

Status check_beneath() {
  BOOST_OUTCOME_TRY(root, open_folder("/"));
  const int fd = openat2(root.get(), ".", O_PATH, Links::refused);
  if (fd < 0) {
    return io_error(
        "openat2",
        "this system call is needed to keep paths inside their folders, and it fails; it needs Linux 5.6 or "
        "newer, and a sandbox must not forbid it",
        errno);
  }
  const FileHandle opened(fd);
  return success();
}

}  // namespace tessera::service

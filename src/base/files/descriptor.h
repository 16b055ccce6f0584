// An open file descriptor, and reading and writing that no signal and no short write cuts short.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

// Error io, or memory when there is none: "path: what failed: the system's reason".
Error io_error(const std::filesystem::path& path, const std::string& what, int number);

// Closed when it goes.
class FileHandle {
 public:
  FileHandle() = default;
  explicit FileHandle(int fd) : fd_(fd) {}
  FileHandle(FileHandle&& other) noexcept : fd_(other.fd_) { other.fd_ = -1; }
  FileHandle& operator=(FileHandle&& other) noexcept;
  FileHandle(const FileHandle&) = delete;
  FileHandle& operator=(const FileHandle&) = delete;
  ~FileHandle();
  int get() const { return fd_; }
  // Closes now, so that an error the system kept for this moment (network file systems do) is not lost. True when it
  // went well.
  bool close();

 private:
  int fd_ = -1;
};

// `flags` as of open(2), O_CLOEXEC added; a new file gets the rights that the umask leaves. Error io. Does not wait for
// anybody: what is opened for reading is a regular file, or with O_DIRECTORY a folder; what is opened for writing no
// named pipe. Whoever may write to a folder of ours could else have readers wait for ever.
Result<FileHandle> open_handle(const std::filesystem::path& path, int flags);
// The same; the error speaks of the file that `path` is a temporary name of. `rights`: before the umask.
Result<FileHandle> open_handle(const std::filesystem::path& path, int flags, const std::filesystem::path& final_name,
                               mode_t rights = 0666);
// For libraries that open files themselves: error io when they would wait, or read what has no end.
Status check_regular(const std::filesystem::path& path);
// A new file in `folder` to write and read back, without a name: gone when closed, however the process ends. Error io.
Result<FileHandle> nameless_file(const std::filesystem::path& folder);
// In bytes. Error io when it is no regular file. `path` is for the message, here and below.
Result<std::uint64_t> size_of(const FileHandle& file, const std::filesystem::path& path);

// Fills `buffer` from `offset` on; fewer bytes only at the end of the file.
Result<std::size_t> read_up_to(int fd, std::span<std::byte> buffer, std::uint64_t offset,
                               const std::filesystem::path& path);
// Writes all bytes at `offset`; `what` is what the error says has failed. Both functions draw from the ledger of the
// thread (src/base/ledger.h) before they write, and fail as it does.
Status write_at(int fd, std::span<const std::byte> bytes, std::uint64_t offset, const std::filesystem::path& path,
                const char* what = "cannot write");
// Writes all bytes where the descriptor stands, which with O_APPEND is the end.
Status write_on(int fd, std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace tessera

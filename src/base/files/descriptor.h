// Open file descriptors. Reading and writing go on after signals and short transfers.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

// Makes the error "path: what failed: the system's reason". Its code is memory for ENOMEM, else io.
Error io_error(const std::filesystem::path& path, const std::string& what, int number);

// An open file descriptor, closed by the destructor.
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
  // Closes the file now. Returns false when the system reports an error, which network file systems may keep until this
  // moment.
  bool close();

 private:
  int fd_ = -1;
};

// Opens a file. `flags` are those of open(2); O_CLOEXEC is added. A new file gets the rights that the umask leaves.
// Error io. The call never waits. What is opened for reading must be a regular file, or with O_DIRECTORY a folder. What
// is opened for writing must not be a named pipe. Otherwise anyone with write access to a folder could make readers
// wait for ever.
Result<FileHandle> open_handle(const std::filesystem::path& path, int flags);
// The same for a file with a temporary name: errors name the file `final_name`. `rights` is subject to the umask.
Result<FileHandle> open_handle(const std::filesystem::path& path, int flags, const std::filesystem::path& final_name,
                               mode_t rights = 0666);
// For libraries that open files themselves. Error io when reading `path` could wait or never end.
Status check_regular(const std::filesystem::path& path);
// Makes a file without a name in `folder`, to write and read back. The file vanishes when closed, however the process
// ends. Error io.
Result<FileHandle> nameless_file(const std::filesystem::path& folder);
// The size in bytes. Error io when the file is not regular. Here and below `path` is for error messages.
Result<std::uint64_t> size_of(const FileHandle& file, const std::filesystem::path& path);

// Fills `buffer` from `offset` on. Returns the number of bytes, which is smaller than the buffer only at the end of the
// file.
Result<std::size_t> read_up_to(int fd, std::span<std::byte> buffer, std::uint64_t offset,
                               const std::filesystem::path& path);
// Writes all bytes at `offset`. `what` says in errors what failed. write_at() and write_on() draw from the thread's
// ledger (src/base/ledger.h) before they write, and return its error.
Status write_at(int fd, std::span<const std::byte> bytes, std::uint64_t offset, const std::filesystem::path& path,
                const char* what = "cannot write");
// Writes all bytes at the position of the descriptor, which is the end of the file with O_APPEND.
Status write_on(int fd, std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace tessera

// A file of a run folder: opened, used and closed at once, so that a thousand tiles need few descriptors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "src/base/result.h"

namespace tessera {

// Every error is Errc::io and names the file and what the system says, unless said otherwise.
class DiskFile {
 public:
  enum class Mode : std::uint8_t { read, append, replace };

  static Result<DiskFile> open(const std::filesystem::path& path, Mode mode);
  DiskFile(DiskFile&& other) noexcept : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}
  DiskFile& operator=(DiskFile&&) = delete;
  ~DiskFile();

  Result<std::uint64_t> size() const;
  // Up to buffer.size() bytes; fewer only at the end of the file.
  Result<std::size_t> read(std::span<std::byte> buffer);
  Status write(std::span<const std::byte> bytes);
  Status sync();
  // Also reports what a network file system only tells on closing.
  Status close();

 private:
  DiskFile(std::filesystem::path path, int fd) : path_(std::move(path)), fd_(fd) {}
  std::filesystem::path path_;
  int fd_;
};

// A file mapped for reading. REQUIRES: nobody truncates it meanwhile.
class MappedFile {
 public:
  static Result<MappedFile> open(const std::filesystem::path& path);
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> bytes_;
};

// Writes `text` to `path` so that a crash leaves the old file or the new one: temporary name, fsync, rename.
Status write_atomically(const std::filesystem::path& path, const std::string& text);

Error system_error(const std::filesystem::path& path, const char* what, int code);

}  // namespace tessera

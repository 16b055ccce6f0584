// A file read or written from its beginning to its end: opened, used and closed at once, so that a thousand tiles need
// few descriptors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera {

// Every error is Errc::io and names the file and what the system says.
class DiskFile {
 public:
  enum class Mode : std::uint8_t { read, append, replace };

  static Result<DiskFile> open(const std::filesystem::path& path, Mode mode);

  Result<std::uint64_t> size() const { return size_of(file_, path_); }
  // Up to buffer.size() bytes; fewer only at the end of the file.
  Result<std::size_t> read(std::span<std::byte> buffer);
  Status write(std::span<const std::byte> bytes) { return write_on(file_.get(), bytes, path_); }
  // Also reports what a network file system only tells on closing.
  Status close();

 private:
  DiskFile(std::filesystem::path path, FileHandle file) : path_(std::move(path)), file_(std::move(file)) {}
  std::filesystem::path path_;
  FileHandle file_;
  std::uint64_t read_ = 0;
};

}  // namespace tessera

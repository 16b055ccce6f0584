// A file as bytes in memory, read when they are touched.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera {

// REQUIRES: no process truncates the file meanwhile.
class MappedFile {
 public:
  // Error io.
  static Result<MappedFile> open(const std::filesystem::path& path);
  // The same for an open file, which may be closed afterwards. `path` is for errors.
  static Result<MappedFile> open(const FileHandle& file, const std::filesystem::path& path);
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> bytes_;
};

}  // namespace tessera

// A file that is read or written once from beginning to end. Each file is opened, used and closed at once, so a
// thousand tiles need few descriptors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera {

// Errors name the file and what the system says. Their code is io, or memory; writing may also fail as the thread's
// ledger does.
class DiskFile {
 public:
  enum class Mode : std::uint8_t { read, append, replace };

  static Result<DiskFile> open(const std::filesystem::path& path, Mode mode);

  Result<std::uint64_t> size() const { return size_of(file_, path_); }
  // Reads on from where the last call ended. Fewer bytes than buffer.size() come only at the end of the file.
  Result<std::size_t> read(std::span<std::byte> buffer);
  Status write(std::span<const std::byte> bytes) { return write_on(file_.get(), bytes, path_); }
  // Closes the file. Also reports errors that a network file system tells only on closing.
  Status close();

 private:
  DiskFile(std::filesystem::path path, FileHandle file) : path_(std::move(path)), file_(std::move(file)) {}
  std::filesystem::path path_;
  FileHandle file_;
  std::uint64_t read_ = 0;
};

}  // namespace tessera

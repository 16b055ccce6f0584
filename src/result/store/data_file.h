// A file of a result that is open for reading: a file on a disk, or an object on another machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera {

class DataFile {
 public:
  // Fills `out` with the bytes from the offset on, all of which the file has.
  using Read = std::function<Status(std::uint64_t offset, std::span<std::byte> out)>;

  // Opens a file on a disk. Error io.
  static Result<DataFile> open(const std::filesystem::path& path);
  // A file of `bytes` bytes that `read` reads. `name` is for errors.
  DataFile(std::filesystem::path name, std::uint64_t bytes, Read read);

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t bytes() const { return bytes_; }
  // Fills `out` from the offset on. Returns the number of bytes, which is smaller than `out` only at the end of the
  // file. Errors: io; those of `read`.
  Result<std::size_t> read_up_to(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  DataFile(std::filesystem::path path, std::uint64_t bytes, FileHandle file);

  std::filesystem::path path_;
  std::uint64_t bytes_ = 0;
  FileHandle file_;
  Read read_;  // null: the open file is read
};

}  // namespace tessera

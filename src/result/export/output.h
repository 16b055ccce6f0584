// Buffered output to a file that appears only when it is complete.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"

namespace tessera::exports {

// The folder of `target`.
std::filesystem::path folder_of(const std::filesystem::path& target);

// A file under a temporary name, which one or more Streams write.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::filesystem::path& target);
  int fd() const { return file_.get(); }
  const std::filesystem::path& target() const { return target_; }
  // Syncs the file and gives it its name. Returns its size.
  Result<std::uint64_t> finish();

 private:
  OutputFile(std::filesystem::path target, TemporaryFile temporary, FileHandle file)
      : target_(std::move(target)), temporary_(std::move(temporary)), file_(std::move(file)) {}
  std::filesystem::path target_;
  TemporaryFile temporary_;
  FileHandle file_;
};

// Writes bytes one after the other, from an offset of a file on. Keeps the first error.
class Stream {
 public:
  Stream(const OutputFile& file, std::uint64_t offset) : Stream(file.fd(), file.target(), offset) {}
  // Errors name `path`.
  Stream(int fd, std::filesystem::path path, std::uint64_t offset) : fd_(fd), path_(std::move(path)), offset_(offset) {}
  void text(std::string_view text) { bytes(std::as_bytes(std::span(text.data(), text.size()))); }
  template <class T>
  void value(const T& value) {
    bytes(std::as_bytes(std::span(&value, 1)));
  }
  // Writes the shortest digits that are read back as the same number.
  template <class T>
  void digits(T value) {
    constexpr std::size_t most = 32;
    if (buffer_.size() - used_ < most) write();
    char* at = reinterpret_cast<char*>(buffer_.data()) + used_;
    used_ += static_cast<std::size_t>(std::to_chars(at, at + most, value).ptr - at);
  }
  void bytes(std::span<const std::byte> bytes) {
    if (buffer_.size() - used_ < bytes.size()) write(bytes.size());
    std::memcpy(buffer_.data() + used_, bytes.data(), bytes.size());
    used_ += bytes.size();
  }
  std::uint64_t offset() const { return offset_ + used_; }
  const Status& status() const { return status_; }
  Status flush();

 private:
  static constexpr std::size_t buffer_bytes = std::size_t{1} << 18;
  // Empties the buffer, and makes it at least `wanted` bytes large.
  void write(std::size_t wanted = 0);
  int fd_;
  std::filesystem::path path_;
  std::uint64_t offset_;
  std::vector<std::byte> buffer_;
  std::size_t used_ = 0;
  Status status_ = success();
};

// Escapes `text` for XML text or an attribute value.
std::string xml_text(std::string_view text);

}  // namespace tessera::exports

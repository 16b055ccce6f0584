// Buffered output to a file that appears whole or not at all.
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

// Where `target` is to stand.
std::filesystem::path folder_of(const std::filesystem::path& target);

// A file under a temporary name, written through one Stream or more.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::filesystem::path& target);
  int fd() const { return file_.get(); }
  const std::filesystem::path& target() const { return target_; }
  // Syncs and renames; the size.
  Result<std::uint64_t> finish();

 private:
  OutputFile(std::filesystem::path target, TemporaryFile temporary, FileHandle file)
      : target_(std::move(target)), temporary_(std::move(temporary)), file_(std::move(file)) {}
  std::filesystem::path target_;
  TemporaryFile temporary_;
  FileHandle file_;
};

// Bytes that follow each other from some place of a file on. The first error is kept.
class Stream {
 public:
  Stream(const OutputFile& file, std::uint64_t offset) : Stream(file.fd(), file.target(), offset) {}
  // `path`: what errors name.
  Stream(int fd, std::filesystem::path path, std::uint64_t offset) : fd_(fd), path_(std::move(path)), offset_(offset) {}
  void text(std::string_view text) { bytes(std::as_bytes(std::span(text.data(), text.size()))); }
  template <class T>
  void value(const T& value) {
    bytes(std::as_bytes(std::span(&value, 1)));
  }
  // The shortest digits that read back as the same number.
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
  // Empties the buffer, and has room for `wanted` bytes then.
  void write(std::size_t wanted = 0);
  int fd_;
  std::filesystem::path path_;
  std::uint64_t offset_;
  std::vector<std::byte> buffer_;
  std::size_t used_ = 0;
  Status status_ = success();
};

// `text` as XML's text or attribute value.
std::string xml_text(std::string_view text);

}  // namespace tessera::exports

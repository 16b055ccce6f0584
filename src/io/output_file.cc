#include "src/io/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 20;

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, std::filesystem::path partial, int file)
    : path_(std::move(path)), partial_(std::move(partial)), file_(file) {
  buffer_.reserve(buffer_bytes);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      partial_(std::move(other.partial_)),
      file_(std::exchange(other.file_, -1)),
      flushed_(other.flushed_),
      buffer_(std::move(other.buffer_)) {}

OutputFile::~OutputFile() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(partial_.c_str());
}

Error OutputFile::refused(const std::string& what, int code) const {
  return error(Errc::io, path_.string() + ": " + what + ": " + std::generic_category().message(code));
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return error(Errc::io, path.string() + ": cannot be written: it is a directory");
  std::filesystem::path partial = path;
  partial += ".partial-" + std::to_string(::getpid());
  const int file = ::open(partial.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  const int code = errno;
  if (file < 0) return error(Errc::io, path.string() + ": cannot be written: " + std::generic_category().message(code));
  return OutputFile(path, std::move(partial), file);
}

Status OutputFile::append(std::span<const std::byte> bytes) {
  if (buffer_.size() + bytes.size() > buffer_bytes) {
    BOOST_OUTCOME_TRYV(flush());
  }
  if (bytes.size() >= buffer_bytes) {
    BOOST_OUTCOME_TRYV(write_at(flushed_, bytes));
    flushed_ += bytes.size();
    return success();
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  return success();
}

Status OutputFile::overwrite(std::uint64_t offset, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(flush());
  return write_at(offset, bytes);
}

Status OutputFile::commit() {
  BOOST_OUTCOME_TRYV(flush());
  if (::fsync(file_) != 0) return refused("cannot be written", errno);
  // close() reports what a network file system had kept to itself.
  if (::close(std::exchange(file_, -1)) != 0 || std::rename(partial_.c_str(), path_.c_str()) != 0) {
    const int code = errno;
    ::unlink(partial_.c_str());
    return refused("cannot be written", code);
  }
  return success();
}

Status OutputFile::flush() {
  BOOST_OUTCOME_TRYV(write_at(flushed_, buffer_));
  flushed_ += buffer_.size();
  buffer_.clear();
  return success();
}

Status OutputFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto put = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) return refused("cannot be written", errno);
    offset += static_cast<std::uint64_t>(put);
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
  return success();
}

}  // namespace tessera

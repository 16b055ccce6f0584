// Files that appear whole or not at all: written under a temporary name, synced, renamed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"

namespace tessera::store {

// Error io: "path: what failed: the system's reason".
Error io_error(const std::filesystem::path& path, const std::string& what, int number);

// An open file descriptor, closed when it goes.
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
  // Closes now, so that an error the system kept for this moment is not lost. True when it went well.
  bool close();

 private:
  int fd_ = -1;
};

// Removes the file when it goes, unless the file was kept.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)) {}
  TemporaryFile(TemporaryFile&& other) noexcept : path_(std::move(other.path_)) { other.path_.clear(); }
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile();
  const std::filesystem::path& path() const { return path_; }
  void keep() { path_.clear(); }

 private:
  std::filesystem::path path_;
};

// A file in memory; holes take none.
class MemoryFile {
 public:
  // `bytes_max`: how large it may become. Error io when the process may not write files of that size; `path` is for the
  // message.
  static Result<MemoryFile> create(std::uint64_t bytes_max, const std::filesystem::path& path);
  int fd() const { return file_.get(); }
  Result<std::uint64_t> size() const;
  Result<std::vector<std::byte>> read(std::uint64_t begin, std::uint64_t end) const;

 private:
  MemoryFile(FileHandle file, std::filesystem::path path) : file_(std::move(file)), path_(std::move(path)) {}
  FileHandle file_;
  std::filesystem::path path_;
};

std::filesystem::path temporary_name(const std::filesystem::path& final_name);

Status make_directories(const std::filesystem::path& folder);
// Syncs `temporary` and renames it: under its name there is the whole file or none. After sync_folder() of its folder
// it survives a power cut there.
Status publish(const std::filesystem::path& temporary, const std::filesystem::path& final_name);
Status sync_folder(const std::filesystem::path& folder);
// Writes the whole file, publishes it and syncs its folder.
Status write_whole(const std::filesystem::path& final_name, std::span<const std::byte> bytes);
Status write_whole(const std::filesystem::path& final_name, std::string_view text);
// Error io when it is missing or unreadable.
Result<std::vector<std::byte>> read_whole(const std::filesystem::path& path);

// Writes all bytes at `offset`; `path` is for the message.
Status write_at(int fd, std::span<const std::byte> bytes, std::uint64_t offset, const std::filesystem::path& path);

}  // namespace tessera::store

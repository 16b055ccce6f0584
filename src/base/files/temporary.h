// Files and folders that are gone when their owner is. A forked child has copies of their owners: what goes with those
// stays, for the parent still has it.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <filesystem>
#include <utility>

#include "src/base/result.h"

namespace tessera {

// Removes the file of this name when it goes, unless the file was kept. Makes none.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)) {}
  TemporaryFile(TemporaryFile&& other) noexcept : path_(std::exchange(other.path_, {})), process_(other.process_) {}
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile();
  const std::filesystem::path& path() const { return path_; }
  void keep() { path_.clear(); }

 private:
  std::filesystem::path path_;
  pid_t process_ = ::getpid();
};

// Where temporary files go: the folder that was wished for, or when that is empty the system's. Error io.
Result<std::filesystem::path> folder_for_temporary(std::filesystem::path wished = {});

// A folder, removed with all that is in it.
class TemporaryFolder {
 public:
  // With a new name under std::filesystem::temp_directory_path(). Error io.
  static Result<TemporaryFolder> make();
  // Of this name. Error io, also when it exists.
  static Result<TemporaryFolder> make(const std::filesystem::path& path);
  TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::exchange(other.path_, {})), process_(other.process_) {}
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }
  void keep() { path_.clear(); }

 private:
  explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
  pid_t process_ = ::getpid();
};

}  // namespace tessera

// Files and folders that are removed with their owner objects. A forked child has copies of these objects. Destroying
// the copies removes nothing, because the parent still needs the files.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <filesystem>
#include <utility>

#include "src/base/result.h"

namespace tessera {

// Removes the file `path` when destroyed, unless keep() was called. Does not make the file.
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

// The folder for temporary files: `wished`, or the system's when `wished` is empty. Error io.
Result<std::filesystem::path> folder_for_temporary(std::filesystem::path wished = {});

// A folder that is removed with everything in it, unless keep() was called.
class TemporaryFolder {
 public:
  // Makes a folder with a new name in the system's folder for temporary files. Error io.
  static Result<TemporaryFolder> make();
  // Makes the folder `path`. Error io, also when it exists.
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

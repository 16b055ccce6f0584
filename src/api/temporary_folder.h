// A folder with a name of its own that is gone when its owner is.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

class TemporaryFolder {
 public:
  // Under std::filesystem::temp_directory_path(). Error io.
  static Result<TemporaryFolder> make();
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  ~TemporaryFolder();  // with all that is in it

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

}  // namespace tessera

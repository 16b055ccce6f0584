// A folder that is TMPDIR while a test runs, so that what the library leaves in it can be counted.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <iterator>
#include <optional>
#include <string>

namespace tessera::testing {

class TemporaryHome {
 public:
  TemporaryHome() {
    if (const char* before = ::getenv("TMPDIR")) before_ = before;
    std::string name = (std::filesystem::temp_directory_path() / "tessera-api-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
    ::setenv("TMPDIR", path_.c_str(), 1);
  }
  TemporaryHome(const TemporaryHome&) = delete;
  TemporaryHome& operator=(const TemporaryHome&) = delete;
  ~TemporaryHome() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
    before_ ? ::setenv("TMPDIR", before_->c_str(), 1) : ::unsetenv("TMPDIR");
  }
  const std::filesystem::path& path() const { return path_; }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
  std::optional<std::string> before_;
};

}  // namespace tessera::testing

// What stands in a folder, and removing it, without any memory of ours. In place of std::filesystem's iterators and
// remove_all(): libstdc++ makes an entry's path in a noexcept function, which ends the process when there is no memory
// for it, and what has run out of memory must still be able to clean up.
#pragma once

#include <dirent.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// while (const char* name = reader.next()) ...
class FolderReader {
 public:
  // What goes wrong is told by error().
  explicit FolderReader(const std::filesystem::path& folder) noexcept;
  FolderReader(const FolderReader&) = delete;
  FolderReader& operator=(const FolderReader&) = delete;
  ~FolderReader();
  // The names in it, without "." and "..", in no order. Null at the end, and after an error. Until the next call.
  const char* next() noexcept;
  std::error_code error() const { return error_; }

 private:
  ::DIR* folder_;
  std::error_code error_;
};

// All names in it, in order. Error io.
Result<std::vector<std::string>> sorted_names(const std::filesystem::path& folder);

// Removes a file, or a folder with all that is in it; links are not followed. No error when there is nothing.
std::error_code remove_tree(const std::filesystem::path& path) noexcept;
// The same, with a sentence for what the system refuses. Errors: io, memory.
Status remove_whole(const std::filesystem::path& path);

}  // namespace tessera

// Lists and removes folders without allocating memory. std::filesystem's iterators and remove_all() do not serve:
// libstdc++ makes an entry's path in a noexcept function, which ends the process when memory runs out. Code that has
// run out of memory must still be able to clean up.
#pragma once

#include <dirent.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// Lists a folder: while (const char* name = reader.next()) ...
class FolderReader {
 public:
  // An error of opening is told by error().
  explicit FolderReader(const std::filesystem::path& folder) noexcept;
  FolderReader(const FolderReader&) = delete;
  FolderReader& operator=(const FolderReader&) = delete;
  ~FolderReader();
  // Returns the next name other than "." and "..", in no order. Null at the end and after an error. The name is valid
  // until the next call.
  const char* next() noexcept;
  std::error_code error() const { return error_; }

 private:
  ::DIR* folder_;
  std::error_code error_;
};

// All names in a folder, sorted. Error io.
Result<std::vector<std::string>> sorted_names(const std::filesystem::path& folder);

// Removes a file, or a folder with everything in it. Does not follow links. A missing path is no error.
std::error_code remove_tree(const std::filesystem::path& path) noexcept;
// The same, with an error that is a sentence. Errors: io, memory.
Status remove_whole(const std::filesystem::path& path);

}  // namespace tessera

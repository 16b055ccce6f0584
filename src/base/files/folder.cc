#include "src/base/files/folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>

#include "src/base/files/descriptor.h"

namespace tessera {
namespace {

bool is_entry(const ::dirent& entry) {
  const std::string_view name = entry.d_name;
  return name != "." && name != "..";
}

// Removes an entry of `folder` with everything in it. Returns 0 or the error number.
int remove_at(int folder, const char* name) noexcept {
  if (::unlinkat(folder, name, 0) == 0 || errno == ENOENT || errno == ENOTDIR) return 0;
  const int refused = errno;
  if (refused != EISDIR && refused != EPERM) return refused;
  const int below = ::openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (below < 0) return errno == ENOENT ? 0 : errno == ENOTDIR ? refused : errno;
  ::DIR* const entries = ::fdopendir(below);
  if (entries == nullptr) {
    const int failed = errno;
    ::close(below);
    return failed;
  }
  int failed = 0;
  while (failed == 0) {
    errno = 0;
    const ::dirent* entry = ::readdir(entries);
    if (entry == nullptr) {
      failed = errno;
      break;
    }
    if (is_entry(*entry)) failed = remove_at(below, entry->d_name);
  }
  ::closedir(entries);
  if (failed == 0 && ::unlinkat(folder, name, AT_REMOVEDIR) != 0 && errno != ENOENT) failed = errno;
  return failed;
}

}  // namespace

FolderReader::FolderReader(const std::filesystem::path& folder) noexcept : folder_(::opendir(folder.c_str())) {
  if (folder_ == nullptr) error_.assign(errno, std::generic_category());
}

FolderReader::~FolderReader() {
  if (folder_ != nullptr) ::closedir(folder_);
}

const char* FolderReader::next() noexcept {
  while (folder_ != nullptr && !error_) {
    errno = 0;
    const ::dirent* entry = ::readdir(folder_);
    if (entry == nullptr) {
      error_.assign(errno, std::generic_category());
      return nullptr;
    }
    if (is_entry(*entry)) return entry->d_name;
  }
  return nullptr;
}

Result<std::vector<std::string>> sorted_names(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  FolderReader reader(folder);
  while (const char* name = reader.next()) names.emplace_back(name);
  if (reader.error()) return io_error(folder, "cannot be read", reader.error().value());
  std::sort(names.begin(), names.end());
  return names;
}

std::error_code remove_tree(const std::filesystem::path& path) noexcept {
  return {remove_at(AT_FDCWD, path.c_str()), std::generic_category()};
}

Status remove_whole(const std::filesystem::path& path) {
  if (const auto failed = remove_tree(path)) return io_error(path, "cannot be removed", failed.value());
  return success();
}

}  // namespace tessera

#include "src/base/files/there.h"

#include <cerrno>

#include "src/base/files/descriptor.h"
#include "src/base/files/folder.h"

namespace tessera {
namespace {

constexpr const char* not_examined = "cannot be examined";

}  // namespace

Result<std::optional<struct stat>> look_at(const std::filesystem::path& path, FollowLinks links) {
  struct stat found {};
  const int failed = links == FollowLinks::yes ? ::stat(path.c_str(), &found) : ::lstat(path.c_str(), &found);
  if (failed == 0) return std::optional(found);
  if (errno == ENOENT || errno == ENOTDIR) return std::optional<struct stat>();
  return io_error(path, not_examined, errno);
}

Result<bool> is_there(const std::filesystem::path& path, FollowLinks links) {
  BOOST_OUTCOME_TRY(found, look_at(path, links));
  return found.has_value();
}

Result<bool> is_folder(const std::filesystem::path& path, FollowLinks links) {
  BOOST_OUTCOME_TRY(found, look_at(path, links));
  return found && S_ISDIR(found->st_mode);
}

Result<bool> is_regular(const std::filesystem::path& path, FollowLinks links) {
  BOOST_OUTCOME_TRY(found, look_at(path, links));
  return found && S_ISREG(found->st_mode);
}

Result<bool> is_empty_folder(const std::filesystem::path& path) {
  FolderReader reader(path);
  const bool empty = reader.next() == nullptr;
  if (reader.error()) return io_error(path, not_examined, reader.error().value());
  return empty;
}

Result<std::uint64_t> file_bytes(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(path));
  if (bytes) return *bytes;
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return io_error(path, not_examined, ENOENT);
  return error(Errc::io, path.string() + ": is not a regular file");
}

Result<std::optional<std::uint64_t>> bytes_if_there(const std::filesystem::path& path, FollowLinks links) {
  BOOST_OUTCOME_TRY(found, look_at(path, links));
  if (!found || !S_ISREG(found->st_mode)) return std::optional<std::uint64_t>();
  return std::optional(static_cast<std::uint64_t>(found->st_size));
}

}  // namespace tessera

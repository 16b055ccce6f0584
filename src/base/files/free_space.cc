#include "src/base/files/free_space.h"

#include <sys/statvfs.h>

namespace tessera {

std::optional<std::uint64_t> known_free_bytes(const std::filesystem::path& folder) {
  struct statvfs status {};
  // File systems that do not know their size report 0.
  if (::statvfs(folder.c_str(), &status) != 0 || status.f_blocks == 0) return std::nullopt;
  return static_cast<std::uint64_t>(status.f_bavail) * status.f_frsize;
}

std::uint64_t free_bytes(const std::filesystem::path& folder) { return known_free_bytes(folder).value_or(0); }

Status check_room(const std::filesystem::path& folder, const std::string& what, std::uint64_t needed,
                  std::optional<std::uint64_t> free) {
  if (!free || *free >= needed) return success();
  return error(Errc::io, folder.string() + ": " + what + " needs up to " + std::to_string((needed >> 20) + 1) +
                             " MiB, and the disk has " + std::to_string(*free >> 20) + " MiB left");
}

}  // namespace tessera

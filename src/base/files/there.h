// What is under a name. "Nothing" is returned only when the system says that nothing is there. When a disk fails, a
// server does not answer or rights are missing, what is there is unknown; taking it for nothing would have it
// overwritten, removed or forgotten. So std::filesystem is not asked, because its functions say false for all of these
// alike.
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <optional>

#include "src/base/result.h"

namespace tessera {

// Whether a link's target is meant, or the link itself. A followed link to nothing counts as nothing.
enum class FollowLinks : bool { no, yes };

// The status of a path. Nothing when the system says that there is none (ENOENT, ENOTDIR). Here and below other reasons
// are error io.
Result<std::optional<struct stat>> look_at(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);

Result<bool> is_there(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);
Result<bool> is_folder(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);
Result<bool> is_regular(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);
// Error io also when the path is no folder.
Result<bool> is_empty_folder(const std::filesystem::path& path);

// The size of a regular file in bytes. Error io also when there is none.
Result<std::uint64_t> file_bytes(const std::filesystem::path& path);
// The same, but nothing when there is no regular file.
Result<std::optional<std::uint64_t>> bytes_if_there(const std::filesystem::path& path,
                                                    FollowLinks links = FollowLinks::yes);

}  // namespace tessera

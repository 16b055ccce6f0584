// What stands under a name. "Nothing" is said only when the system says that nothing stands there. Of a disk that
// fails, a server that does not answer or rights that are missing, nobody knows what stands there: what was taken for
// nothing would be written over, removed or forgotten. So std::filesystem is not asked: its exists(path, code) is false
// for all of these alike.
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <filesystem>
#include <optional>

#include "src/base/result.h"

namespace tessera {

// Whether a link's target is meant, or the link itself. A link to nothing is nothing when it is followed.
enum class FollowLinks : bool { no, yes };

// Nothing when the system says that there is none (ENOENT, ENOTDIR). Error io for each other reason, here and below.
Result<std::optional<struct stat>> look_at(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);

Result<bool> is_there(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);
Result<bool> is_folder(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);
Result<bool> is_regular(const std::filesystem::path& path, FollowLinks links = FollowLinks::yes);
// Error io also when it is no folder.
Result<bool> is_empty_folder(const std::filesystem::path& path);

// The size of a regular file. Error io also when there is none.
Result<std::uint64_t> file_bytes(const std::filesystem::path& path);
// Nothing when there is no regular file.
Result<std::optional<std::uint64_t>> bytes_if_there(const std::filesystem::path& path,
                                                    FollowLinks links = FollowLinks::yes);

}  // namespace tessera

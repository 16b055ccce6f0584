// Files below a folder, and nowhere else: whatever a path says, and whatever links it meets (openat2, Linux 5.6).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera {

enum class Links : bool { refused, followed_beneath };

// `path` from the open folder on; `flags` as of open(2), O_CLOEXEC added. Errors name `path`: usage when it leads out
// of the folder, by "..", by a link or by being absolute, or holds a zero byte; io. Never waits (of a FIFO, for one).
Result<FileHandle> open_beneath(const FileHandle& folder, const std::string& path, int flags, Links links);

// The same; nothing when the system says that nothing is there.
Result<std::optional<FileHandle>> open_if_there(const FileHandle& folder, const std::string& path, int flags,
                                                Links links);

// To look for files in, not to list it. Error io.
Result<FileHandle> open_folder(const std::filesystem::path& folder);

// Where an open file or folder is now, without links. Error io.
Result<std::filesystem::path> real_path(const FileHandle& file);
// The same file by another way, for what takes a path: while `file` is open.
std::filesystem::path path_of(const FileHandle& file);

// Error io when this kernel cannot open files so.
Status check_beneath();

}  // namespace tessera

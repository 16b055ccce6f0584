// Opens files below a folder and nowhere else, whatever a path says and whatever links it meets (openat2, Linux 5.6).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "src/base/files/descriptor.h"
#include "src/base/result.h"

namespace tessera::service {

enum class Links : bool { refused, followed_beneath };

// Opens `path` relative to the open folder. `flags` are those of open(2); O_CLOEXEC is added. Never waits, for example
// for a FIFO. Errors, which name `path`: usage when it leads out of the folder (by "..", by a link or because it is
// absolute) or holds a zero byte; io.
Result<FileHandle> open_beneath(const FileHandle& folder, const std::string& path, int flags, Links links);

// The same; returns nothing when the file does not exist.
Result<std::optional<FileHandle>> open_if_there(const FileHandle& folder, const std::string& path, int flags,
                                                Links links);

// Opens a folder to look for files in, not to list it. Error io.
Result<FileHandle> open_folder(const std::filesystem::path& folder);

// The current path of an open file or folder, without links. Error io.
Result<std::filesystem::path> real_path(const FileHandle& file);
// A path that means the open file, for functions that need a path. Valid while `file` is open.
std::filesystem::path path_of(const FileHandle& file);

// Error io when this kernel lacks openat2.
Status check_beneath();

}  // namespace tessera::service

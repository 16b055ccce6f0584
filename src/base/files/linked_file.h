// A second name of a file.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

// Makes a hard link, or a copy where the file system has no hard links. Replaces a file that an earlier process may
// have left at `to`. Error io.
Status link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace tessera

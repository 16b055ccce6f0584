// Paths that another process names.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

// Error usage unless `path` lies in `folder`, links followed as far as there is something.
Status check_inside(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace tessera

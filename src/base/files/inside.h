// Checks paths that another process has named.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera {

// Error usage unless `path` lies in `folder`. Links are followed as far as the path exists.
Status check_inside(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace tessera

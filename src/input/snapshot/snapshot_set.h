// Snapshots that are split into several files.
#pragma once

#include <span>

#include "src/base/result.h"
#include "src/input/reader.h"

namespace tessera::snapshot {

// Checks that each snapshot has all its files, and no others. Files NAME.0, NAME.1, ... in one folder belong together.
// Error bad_input for a file that is missing, that is there twice, or that is of another snapshot than the others.
Status check_snapshots(std::span<const FileInfo> files);

}  // namespace tessera::snapshot

// Decides which versions of the service understand a data folder.
#pragma once

#include <filesystem>

#include "src/base/result.h"

namespace tessera::service {

// Checks the format of `data`, and writes it when there is none yet. Errors: corrupt for a folder of a newer version,
// and for a damaged format file; io.
Status check_data_format(const std::filesystem::path& data);

// The identity of this data folder, which is the same on all machines and differs from that of any other folder. The
// first call makes it. Errors: io, corrupt.
Result<std::string> data_identity(const std::filesystem::path& data);

}  // namespace tessera::service

// Whether a file is the one that its manifest tells of.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/files/checksum.h"
#include "src/base/result.h"

namespace tessera {

// Error corrupt when the file has not this checksum, io when it cannot be read.
Status check_sum(const std::filesystem::path& path, std::uint64_t expected, SumOf what = SumOf::bytes);

}  // namespace tessera

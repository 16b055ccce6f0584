// Checks a file against the checksum in its manifest.
#pragma once

#include <cstdint>
#include <filesystem>

#include "src/base/files/checksum.h"
#include "src/base/result.h"

namespace tessera {

// Errors: corrupt when the file has another checksum than `expected`; io when the file cannot be read.
Status check_sum(const std::filesystem::path& path, std::uint64_t expected, ChecksumOf what = ChecksumOf::bytes);

}  // namespace tessera

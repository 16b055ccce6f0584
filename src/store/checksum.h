// XXH3-64, as files are checksummed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

std::uint64_t checksum(std::span<const std::byte> bytes);
// Of the whole file, streamed. Error io when it cannot be read.
Result<std::uint64_t> checksum_file(const std::filesystem::path& path);
// 16 lower-case hexadecimal digits, as in the manifest.
std::string checksum_text(std::uint64_t value);

}  // namespace tessera

// How much room a file system has.
#pragma once

#include <cstdint>
#include <filesystem>

namespace tessera {

// Bytes that this process may still write there; 0 when it cannot be told.
std::uint64_t free_bytes(const std::filesystem::path& folder);

}  // namespace tessera

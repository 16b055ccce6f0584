// The free space of a file system.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

// The bytes that this process may still write to the file system of `folder`. Nothing when the file system does not
// tell.
std::optional<std::uint64_t> known_free_bytes(const std::filesystem::path& folder);
// The same, but 0 when the file system does not tell.
std::uint64_t free_bytes(const std::filesystem::path& folder);

// Error io, with both figures, when `free` is less than `needed`. `free` comes from known_free_bytes(folder), and
// `what` needs the space: "the tileset". When `free` is unknown the check succeeds, and writing will tell.
Status check_room(const std::filesystem::path& folder, const std::string& what, std::uint64_t needed,
                  std::optional<std::uint64_t> free);

}  // namespace tessera

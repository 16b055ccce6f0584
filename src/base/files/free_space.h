// How much room a file system has.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "src/base/result.h"

namespace tessera {

// Bytes that this process may still write there; nothing when the file system does not tell.
std::optional<std::uint64_t> known_free_bytes(const std::filesystem::path& folder);
// The same; 0 when it cannot be told.
std::uint64_t free_bytes(const std::filesystem::path& folder);

// Error io, with both figures, when `free`, that known_free_bytes() tells of the folder, is less than `needed`. `what`
// needs it: "the tileset". What nobody can tell is found out by writing.
Status check_room(const std::filesystem::path& folder, const std::string& what, std::uint64_t needed,
                  std::optional<std::uint64_t> free);

}  // namespace tessera

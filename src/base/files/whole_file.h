// Files that appear whole or not at all: written under a temporary name, synced, renamed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// With the folders above it; one that exists is fine. Error io, here and below.
Status make_directories(const std::filesystem::path& folder);
// The file alone; a missing one is fine.
Status remove_file(const std::filesystem::path& path);
// Atomic: under `to` there is the old file or the new one.
Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to);

// Syncs `temporary` and renames it: under its name there is the whole file or none. After sync_folder() of its folder
// it survives a power cut there.
Status publish(const std::filesystem::path& temporary, const std::filesystem::path& final_name);
Status sync_folder(const std::filesystem::path& folder);
// Many files at once: each waits for the disk, and not for the others. The first error, if any.
Status sync_files(std::span<const std::filesystem::path> files);

// Writes the whole file, publishes it and syncs its folder.
Status write_whole(const std::filesystem::path& final_name, std::span<const std::byte> bytes);
Status write_whole(const std::filesystem::path& final_name, std::string_view text);
// The same; no one but its owner can read it, from its first moment.
Status write_private(const std::filesystem::path& final_name, std::span<const std::byte> bytes);
// Error io also when it is no regular file.
Result<std::vector<std::byte>> read_whole(const std::filesystem::path& path);

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace tessera

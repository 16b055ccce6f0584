// Files that appear whole or not at all: they are written under a temporary name, synced and renamed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// Makes a folder and the folders above it. An existing folder is no error. Error io, here and below.
Status make_directories(const std::filesystem::path& folder);
// Removes one file. A missing file is no error.
Status remove_file(const std::filesystem::path& path);
// Renames atomically: at any time `to` is the old file or the new one.
Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to);

// Syncs `temporary` and renames it, so that `final_name` is the whole file or nothing. After sync_folder() of its
// folder the file survives a power cut.
Status publish(const std::filesystem::path& temporary, const std::filesystem::path& final_name);
Status sync_folder(const std::filesystem::path& folder);
// Syncs many files at once, so that they wait for the disk together. Returns the first error, if any.
Status sync_files(std::span<const std::filesystem::path> files);

// Writes a whole file, publishes it and syncs its folder.
Status write_whole(const std::filesystem::path& final_name, std::span<const std::byte> bytes);
Status write_whole(const std::filesystem::path& final_name, std::string_view text);
// The same, for a file that only its owner can read, from its first moment on.
Status write_private(const std::filesystem::path& final_name, std::span<const std::byte> bytes);
// Error io also when the file is not regular.
Result<std::vector<std::byte>> read_whole(const std::filesystem::path& path);

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace tessera

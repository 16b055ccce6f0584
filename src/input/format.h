// Which format bytes are in: by their begin, then by their name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

enum class FileFormat : std::uint8_t { unknown, las, npy, ply, off, obj, stl, text, gzip, zstd };

// So many bytes of the begin are enough.
inline constexpr std::size_t format_bytes = 4096;

// `begin`: the first bytes, up to format_bytes of them. `name`: as ByteSource::content_name(); what has no name at all
// is text if it looks like text. `bytes`: how many there are; binary STL begins like nothing in particular, and is
// known by its size, or without that, by less.
FileFormat format_of(std::span<const std::byte> begin, const std::filesystem::path& name,
                     std::optional<std::uint64_t> bytes = {});

// Whether the name alone, ".gz" and ".zst" taken off, is that of a format we read.
bool has_point_file_name(const std::filesystem::path& path);

// "a.xyz" of a.xyz.gz and a.xyz.zst; other names as they are.
std::filesystem::path without_packing(const std::filesystem::path& path);

// ".las, .laz, ...": how the names of formats we read end.
std::string point_file_endings();

Error unknown_format(const std::filesystem::path& path);

}  // namespace tessera

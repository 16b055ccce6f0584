// Finds the format of bytes: by the first bytes, then by the name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

enum class FileFormat : std::uint8_t {
  unknown,
  las,
  npy,
  ply,
  off,
  obj,
  stl,
  e57,
  ept,
  pcd,
  ptx,
  pts,
  gadget,
  tipsy,
  hdf5,
  fits,
  text,
  gzip,
  zstd
};

// The number of first bytes that is enough to tell the format.
inline constexpr std::size_t format_bytes = 4096;

// Returns the format. `begin` is the first bytes of the content, up to format_bytes. `name` is
// ByteSource::content_name(); content without a name is text if it looks like text. `bytes` is the size of the content,
// if known. Binary STL has no typical first bytes and is known by its size; without a size, less certain signs must do.
FileFormat format_of(std::span<const std::byte> begin, const std::filesystem::path& name,
                     std::optional<std::uint64_t> bytes = {});

// Whether the path's name, without ".gz" or ".zst", is that of a format that can be read.
bool has_point_file_name(const std::filesystem::path& path);

// Returns "a.xyz" for a.xyz.gz and a.xyz.zst, and other names unchanged.
std::filesystem::path without_packing(const std::filesystem::path& path);

// The endings of the formats that can be read: ".las, .laz, ...".
std::string point_file_endings();

// The error, bad_input, for a file of unknown format.
Error unknown_format(const std::filesystem::path& path);

}  // namespace tessera

// STL (stereolithography), text and binary. The corners of the triangles are the points, so a vertex comes once for
// each triangle around it. Normals are skipped, and so are the two bytes of a binary triangle that some programs use
// for colours.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Whether `begin`, the first bytes of a file of `bytes` bytes, is binary STL: the size is 84 bytes and 50 for each
// triangle that the header promises. Without `bytes`, when the size is unknown, the first triangle must be finite
// instead.
bool is_binary_stl(std::span<const std::byte> begin, std::optional<std::uint64_t> bytes);

// Whether `begin` is the beginning of an STL text: "solid NAME", then "facet" or "endsolid".
bool looks_like_text_stl(std::string_view begin);

// Opens an STL file. Binary files may begin with "solid", too; their size tells.
Result<std::unique_ptr<PointReader>> open_stl(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera

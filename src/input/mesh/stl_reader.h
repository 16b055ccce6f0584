// STL (stereolithography), text and binary: the corners of the triangles are the points, so a vertex comes once for
// every triangle around it. Normals and the two bytes of a binary triangle that some programs use for colours are
// skipped.
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

// Whether `begin`, the first bytes of a file of `bytes` bytes, is binary STL: 84 bytes and as many times 50 as its
// header says. Without `bytes` (more is to come, nobody knows how much) whether it may be: its first triangle is
// finite.
bool is_binary_stl(std::span<const std::byte> begin, std::optional<std::uint64_t> bytes);

// Whether a text that begins with `begin` is STL: "solid NAME", then "facet" or "endsolid".
bool looks_like_text_stl(std::string_view begin);

// Binary files may begin with "solid", too: their size tells.
Result<std::unique_ptr<PointReader>> open_stl(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera

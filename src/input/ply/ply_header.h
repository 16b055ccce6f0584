// The header of a PLY file: which elements follow, and what their properties are.
// Source: Greg Turk, The PLY Polygon File Format (1994); type names with sizes (float32) as in later tools.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

enum class PlyFormat { ascii, binary_little_endian, binary_big_endian };

struct PlyProperty {
  std::string name;
  AttributeType type = AttributeType::f32;
  std::optional<AttributeType> count;  // of a list: the type of its length; an integer type
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  // Bytes of one in a binary file; nothing if it has lists.
  std::optional<std::size_t> fixed_bytes() const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;     // which element is "vertex"
  std::uint64_t body_at = 0;  // offset of the first byte after the header
  std::uint64_t lines = 0;    // of the header
};

// Errors bad_input: not PLY, a line that cannot be understood, no element "vertex".
Result<PlyHeader> read_ply_header(const ByteSource& source);

}  // namespace tessera

// The header of a PLY file: the elements that follow, with their properties.
// Source: Greg Turk, The PLY Polygon File Format (1994). Type names with sizes (float32) are from later tools.
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
  std::optional<AttributeType> count;  // only for a list: the type of its length, an integer
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  // The bytes of one element in a binary file. Nothing if the element has lists.
  std::optional<std::size_t> fixed_bytes() const;
};

struct PlyHeader {
  PlyFormat format = PlyFormat::ascii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;     // the index of the element "vertex"
  std::uint64_t body_at = 0;  // the offset of the first byte after the header
  std::uint64_t lines = 0;    // the number of lines of the header
};

// Error bad_input for what is not PLY, for a line that cannot be understood, and without an element "vertex".
Result<PlyHeader> read_ply_header(const ByteSource& source);

}  // namespace tessera

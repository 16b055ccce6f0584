// The header of a PCD file (Point Cloud Library), versions 0.5 to 0.7: the fields of a point, and how points are
// stored. Source: "The PCD (Point Cloud Data) file format", pointclouds.org.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

enum class PcdData : std::uint8_t { ascii, binary, binary_compressed };

// One or several numbers of a point.
struct PcdField {
  std::string name;
  AttributeType type = AttributeType::f32;
  std::size_t count = 1;
  std::size_t bytes() const { return size_of(type) * count; }
};

struct PcdHeader {
  std::vector<PcdField> fields;
  std::uint64_t points = 0;
  PcdData data = PcdData::ascii;
  std::uint64_t body_at = 0;  // the offset of the first byte after the header
  std::uint64_t lines = 0;    // the number of lines of the header
  std::size_t point_bytes() const;
};

// Error bad_input for what is not PCD, and for a line that cannot be understood.
Result<PcdHeader> read_pcd_header(const ByteSource& source);

}  // namespace tessera

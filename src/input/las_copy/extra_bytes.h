// Extra bytes: dimensions of points that are not LAS's own. A record of the file describes them.
// Source: ASPRS, LAS Specification 1.4 - R15 (2019), Extra Bytes VLR.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/las_copy/las_parts.h"

namespace tessera {

struct ExtraDimension {
  std::string name;                         // 1 to 32 bytes
  std::string description;                  // at most 32 bytes
  AttributeType type = AttributeType::f32;  // f32 or f64
};

// How the records of a copy are made of those of the input.
struct RecordChange {
  struct Piece {
    std::size_t at, bytes;
  };
  std::vector<Piece> kept;         // the parts of a record that are kept, in order; the new dimensions follow
  std::uint16_t record_bytes = 0;  // of the copy
};

// Adds descriptors of `dimensions` to the records in `parts`, and returns what becomes of point records. Bytes that no
// descriptor describes get a descriptor without a name, because a reader finds a dimension by the bytes before it. With
// `replace` the input's dimensions of the same names are left out; without it they are error bad_input. Further errors
// bad_input, naming `source`: descriptors of an unknown kind, or of more bytes than records have; no room for more.
// Error usage for a name or a description that is too long. REQUIRES: `header` and `parts` are those of `source`.
Result<RecordChange> add_dimensions(const ByteSource& source, const LasHeader& header, LasParts& parts,
                                    const std::vector<ExtraDimension>& dimensions, bool replace);

// The least and the greatest value of a dimension. NaN has no place among numbers, and does not count.
struct ValueRange {
  double least = std::numeric_limits<double>::infinity(), greatest = -std::numeric_limits<double>::infinity();

  void add(double value) {
    if (value < least) least = value;
    if (value > greatest) greatest = value;
  }
  bool any() const { return least <= greatest; }
};

// Writes the ranges of the dimensions that add_dimensions() has added into their descriptors, for the dimensions that
// have any value. Returns the record of these descriptors. REQUIRES: add_dimensions() has changed `parts`, and has
// added as many dimensions as there are ranges, at least one.
LasRecord& describe_ranges(LasParts& parts, std::span<const ValueRange> ranges);
// True for a record of descriptors.
bool describes_extra_bytes(const LasRecord& record);

}  // namespace tessera

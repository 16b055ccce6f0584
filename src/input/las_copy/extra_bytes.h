// Extra bytes: dimensions of points that are not LAS's own. A record of the file describes them.
// Source: ASPRS, LAS Specification 1.4 - R15 (2019), Extra Bytes VLR.
#pragma once

#include <cstddef>
#include <cstdint>
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

}  // namespace tessera

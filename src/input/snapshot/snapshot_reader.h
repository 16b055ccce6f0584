// Snapshots of simulations: particles whose numbers lie in runs of records, one after the other. Formats describe their
// files as such runs (gadget.h, tipsy.h); one reader reads them all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"
#include "src/input/snapshot/particle_types.h"

namespace tessera::snapshot {

// A number of each record of a run. Columns 0 to 2 are x, y and z; column 3 + i is attribute i of the layout.
struct Field {
  std::size_t column = 0;
  std::size_t offset = 0;  // in bytes, within the record
  AttributeType type = AttributeType::f32;
};

// Records of the particles first .. first + count - 1.
struct Run {
  std::uint64_t first = 0, count = 0;
  std::uint64_t at = 0;  // where the first record begins in the file
  std::size_t record_bytes = 0;
  std::vector<Field> fields;
};

// A number that the particles first .. first + count - 1 share. What neither a run nor a constant gives is NaN, or 0 as
// an integer.
struct Constant {
  std::uint64_t first = 0, count = 0;
  std::size_t column = 0;
  double value = 0;
};

struct Layout {
  std::uint64_t particles = 0;  // of the file
  KeptParticles kept;           // all of them, or those of some types
  std::vector<Attribute> attributes;
  std::vector<Run> runs;
  std::vector<Constant> constants;
  bool swapped = false;  // big endian
};

// Reads the particles that are kept, in the order of the file. Bytes of others are not read. REQUIRES: all runs lie
// within the source.
std::unique_ptr<PointReader> read_layout(FileInfo info, std::unique_ptr<ByteSource> source, Layout layout,
                                         const std::vector<Attribute>& schema);

}  // namespace tessera::snapshot

// The parts of a COPC file that can be read by themselves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera::laz {

// A node of the octree: consecutive records.
struct CopcUnit {
  std::uint64_t first = 0, points = 0;  // records in the file
  std::uint64_t begin = 0, bytes = 0;   // compressed bytes: the first one's place in the file, and their number
  Bounds bounds;                        // a closed box of all its points, as the file states it
};

// Returns the nodes with points that `resolution` needs (see ReadHints), in the order of the file. Reads no points.
// Error bad_input: those of the header, the chunk table and the hierarchy. With resolution 0 also a chunk that is no
// node, because the file does not say where its points are. REQUIRES: the file is COPC.
Result<std::vector<CopcUnit>> read_copc_units(const ByteSource& source, double resolution);

// Fetches what reading rows of these attributes will read of units of a file that is far; see FarSource::bring(). Does
// nothing for other files.
Status bring_copc_units(const ByteSource& source, const std::vector<Attribute>& attributes,
                        std::span<const CopcUnit> units);

}  // namespace tessera::laz

// The parts of a COPC file that can be read by themselves.
#pragma once

#include <cstdint>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera::laz {

// A node of the octree: consecutive records.
struct CopcUnit {
  std::uint64_t first = 0, points = 0;  // records in the file
  std::uint64_t bytes = 0;              // compressed bytes
  Bounds bounds;                        // a closed box of all its points, as the file states it
};

// Returns the nodes with points that `resolution` needs (see ReadHints), in the order of the file. Reads no points.
// Error bad_input: those of the header, the chunk table and the hierarchy. With resolution 0 also a chunk that is no
// node, because the file does not say where its points are. REQUIRES: the file is COPC.
Result<std::vector<CopcUnit>> read_copc_units(const ByteSource& source, double resolution);

}  // namespace tessera::laz

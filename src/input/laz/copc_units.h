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
  std::uint64_t first = 0, points = 0;  // records of the file
  std::uint64_t bytes = 0;              // compressed
  Bounds bounds;                        // closed, of all its points, as the file states them
};

// The nodes with points, as far as `resolution` wants them (see ReadHints), in the order of the file. Reads no points.
// Errors bad_input: those of the header, the chunk table and the hierarchy; with resolution 0 also a chunk that is no
// node: nobody says where its points are. REQUIRES: it is a COPC file.
Result<std::vector<CopcUnit>> read_copc_units(const ByteSource& source, double resolution);

}  // namespace tessera::laz

// COPC: the octree over the chunks of a LAZ file. Source: Hobu, Cloud Optimized Point Cloud Specification 1.0 (2021).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/las/las_header.h"
#include "src/input/laz/chunk_decoder.h"
#include "src/input/reader.h"

namespace tessera::laz {

// A node with points: these are one chunk.
struct CopcNode {
  std::uint64_t offset = 0, bytes = 0, points = 0;
  Bounds bounds;  // of its points, as the file states them: its cube, as far as it is in the header's box
};

// The nodes whose cube meets hints.crop and whose level is not finer than needed: levels 0 to L, L being the first with
// spacing / 2^L <= hints.resolution (all without one). Only the pages that lead to them are read. Errors bad_input: an
// info record or hierarchy that is not one, pages beyond the file or that lead to one another.
// REQUIRES: header.copc is not empty.
Result<std::vector<CopcNode>> read_copc_nodes(const ByteSource& source, const LasHeader& header,
                                              const ReadHints& hints);

// The chunks that are these nodes, in the order of the file. Error bad_input if a node is no chunk.
Result<std::vector<Chunk>> chunks_of_nodes(const std::string& path, const std::vector<Chunk>& chunks,
                                           std::vector<CopcNode> nodes);

}  // namespace tessera::laz

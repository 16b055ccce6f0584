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

// A node of the octree that has points. Such a node is one chunk.
struct CopcNode {
  std::uint64_t offset = 0, bytes = 0, points = 0;
  Bounds bounds;  // a box of its points as the file states it: the node's cube within the header's box
};

// Returns the nodes whose cube meets hints.crop and whose level is not finer than needed. These are the levels 0 to L,
// where L is the first level with spacing / 2^L <= hints.resolution; without a resolution all levels. Only the pages
// that lead to these nodes are read. Error bad_input for a wrong info record or hierarchy, and for pages beyond the
// file or in a circle.
// REQUIRES: header.copc is not empty.
Result<std::vector<CopcNode>> read_copc_nodes(const ByteSource& source, const LasHeader& header,
                                              const ReadHints& hints);

// Returns the chunks of these nodes, in the order of the file. Error bad_input if a node is no chunk.
Result<std::vector<Chunk>> chunks_of_nodes(const std::string& path, const std::vector<Chunk>& chunks,
                                           std::vector<CopcNode> nodes);

}  // namespace tessera::laz

// The points of a PCD file with DATA binary_compressed: columns, one field after the other, packed by LZF.
#pragma once

#include <memory>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/pcd/pcd_header.h"
#include "src/input/ply/ply_vertices.h"

namespace tessera {

// The points as records. Each field is unpacked by a stream of its own, so that memory does not depend on the number of
// points. `coordinates_only` saves the time for the other fields, which are zero. `element` has the properties of the
// records. Error bad_input if the sizes of the packed points contradict the header or the size of the file.
Result<std::unique_ptr<PlyVertices>> open_compressed_vertices(std::unique_ptr<ByteSource> source,
                                                              const PcdHeader& header, const PlyElement& element,
                                                              bool coordinates_only);

}  // namespace tessera

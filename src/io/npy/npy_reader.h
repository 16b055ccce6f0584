// NumPy .npy, format versions 1 to 3: an array of n x 2 or n x 3 floats of 4 or 8 bytes, either byte order, C order.
// Source: NumPy Enhancement Proposal 1 and numpy.lib.format.
#pragma once

#include <memory>
#include <vector>

#include "src/io/bytes/byte_source.h"
#include "src/io/reader.h"

namespace tessera {

Result<std::unique_ptr<PointReader>> open_npy(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera

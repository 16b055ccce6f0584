// NumPy .npy, format versions 1 to 3: an array of n x k floats of 4 or 8 bytes, in C order, or of n rows of named
// columns; either byte order. Source: NumPy Enhancement Proposal 1 and numpy.lib.format.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Without names the columns are x, y, z, column_4, ..., with two of them x and y. Of named ones x, y and z (or X, Y
// and Z) are the coordinates; without z the dimension is 2. The other columns are attributes of their own types. The
// hints' columns take the place of these names.
Result<std::unique_ptr<PointReader>> open_npy(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints = {});

}  // namespace tessera

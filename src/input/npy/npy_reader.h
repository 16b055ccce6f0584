// NumPy .npy, format versions 1 to 3. The array has n x k floats of 4 or 8 bytes in C order, or n rows of named
// columns, in either byte order. Source: NumPy Enhancement Proposal 1 and numpy.lib.format.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Opens a NumPy file. Columns without names are called x, y, z, column_4, ...; with only two columns, x and y. Of named
// columns x, y and z (or X, Y and Z) are the coordinates. Without z the dimension is 2. Other columns are attributes of
// their own types. The columns of `hints` replace these names.
Result<std::unique_ptr<PointReader>> open_npy(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints = {});

}  // namespace tessera

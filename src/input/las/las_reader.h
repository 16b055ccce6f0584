// The reader of LAS 1.0-1.4, point formats 0-10; LAZ, point formats 0-3 and 6-8; and COPC. Coordinates are as in
// decimal_axis.h.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

Result<std::unique_ptr<PointReader>> open_las(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera

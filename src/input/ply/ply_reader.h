// PLY (Stanford polygon format): ASCII, binary little and big endian. The element "vertex" gives the points, its
// numeric properties besides x y z the attributes; other elements and list properties are skipped, wherever they stand.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// ASCII numbers are read as doubles also where the header says float: the text is what the file holds.
Result<std::unique_ptr<PointReader>> open_ply(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera

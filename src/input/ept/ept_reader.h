// The reader of EPT, the format of Entwine: an octree of tiles in files, in LAZ, binary or Zstandard.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Opens a cloud by its ept.json. The files of the tiles are beside it. The points are in the order of the levels, from
// coarse to fine, and in a level by the place of their node. hints.crop and hints.resolution choose nodes. Coordinates
// are as in decimal_axis.h, attributes are called as in LAS.
Result<std::unique_ptr<PointReader>> open_ept(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera

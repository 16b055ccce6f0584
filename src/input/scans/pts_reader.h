// PTS (Leica Cyclone and others): points as text, with their number in a line before them; several such parts may
// follow each other.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Opens a PTS file. A line of 4 or 7 numbers has an intensity behind x, y and z; a line of 6 or 7 ends with red, green
// and blue. The first point tells which of them the file has. A file whose first line is no number of points is read as
// text.
Result<std::unique_ptr<PointReader>> open_pts(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints);

}  // namespace tessera

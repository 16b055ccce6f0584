// STL in text, see stl_reader.h.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Words may stand in any lines, as the format has it, but for "solid" and "endsolid", whose line is theirs. Keywords in
// any case. Triangles that are not whole, and solids that do not end, are errors.
Result<std::unique_ptr<PointReader>> open_stl_text(std::unique_ptr<ByteSource> source,
                                                   const std::vector<Attribute>& attributes);

}  // namespace tessera

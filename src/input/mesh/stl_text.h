// STL as text; see stl_reader.h.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Words may be on any lines, as the format permits. Only "solid" and "endsolid" own the rest of their line. Keywords
// may have any case. Incomplete triangles and solids without an end are errors.
Result<std::unique_ptr<PointReader>> open_stl_text(std::unique_ptr<ByteSource> source,
                                                   const std::vector<Attribute>& attributes);

}  // namespace tessera

// PLY (Stanford polygon format): ASCII, and binary in either byte order. The points are the element "vertex". Its
// numeric properties other than x, y and z are attributes. Other elements and list properties are skipped, wherever
// they are.
#pragma once

#include <memory>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/ply/ply_header.h"
#include "src/input/ply/ply_vertices.h"
#include "src/input/reader.h"

namespace tessera {

// A reader of `vertices`, whose properties are those of `vertex`. `info` says what else is known of the file. A
// property called "_" is left out. Error bad_input without the properties x and y.
Result<std::unique_ptr<PointReader>> read_vertices(FileInfo info, std::unique_ptr<PlyVertices> vertices,
                                                   const PlyElement& vertex, const std::vector<Attribute>& attributes);

// Opens a PLY file. Numbers in ASCII files are read as doubles, even if the header says float, because the text is the
// data.
Result<std::unique_ptr<PointReader>> open_ply(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera

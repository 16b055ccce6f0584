// OBJ (Wavefront): the points are the lines "v x y z", in any order among other lines, whether a face uses them or not.
// A colour after them, "v x y z red green blue", is read as MeshLab and other programs write it. Everything else is
// skipped.
// Source: Wavefront, Advanced Visualizer, appendix B1: Object Files.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Whether `begin`, the first bytes of a text, is OBJ: the first statement that is not another OBJ keyword is a vertex,
// "v" and numbers.
bool looks_like_obj(std::string_view begin);

// Opens an OBJ file. If the first vertex has a colour, vertices have colours, and missing colours are NaN. A weight ("v
// x y z w") must be 1.
Result<std::unique_ptr<PointReader>> open_obj(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera

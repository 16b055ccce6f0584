// OBJ (Wavefront): the lines "v x y z", in any order among others, are the points, whether a face uses them or not. A
// colour behind them, "v x y z red green blue", is read as MeshLab and others write it; everything else is skipped.
// Source: Wavefront, Advanced Visualizer, appendix B1: Object Files.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/input/bytes/byte_source.h"
#include "src/input/reader.h"

namespace tessera {

// Whether `begin`, the first bytes of a text, is OBJ: before anything else stands a vertex, "v" and a number.
bool looks_like_obj(std::string_view begin);

// The first vertex tells whether there are colours; those of vertices without one are NaN. A weight ("v x y z w")
// must be 1.
Result<std::unique_ptr<PointReader>> open_obj(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes);

}  // namespace tessera
